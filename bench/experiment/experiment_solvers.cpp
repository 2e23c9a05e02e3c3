#include "bench/experiment/experiment_solvers.h"

#include <algorithm>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/entry_check.h"
#include "bench/experiment/experiment.h"
#include "bench/experiment/names.h"
#include "bench/experiment/sweep.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::size_t most_seeds = 100;

std::vector<std::optional<int>> read_seeds(JsonObject& entry, const std::string& type,
                                           const SolverInfo* info) {
  if (!entry.has("seeds")) return {std::nullopt};
  const json& values = entry.raw("seeds");
  if (!values.is_array() || values.empty() || values.size() > most_seeds) {
    entry.fail("seeds", "must be a list of 1 to " + std::to_string(most_seeds) + " whole numbers");
  }
  if (entry.value().contains("seed")) {
    entry.fail("seeds", "stands beside \"seed\"; remove one of the two");
  }
  if (info && !info->has_seed()) {
    entry.fail("seeds", type + " has no training seed; remove it");
  }
  std::vector<std::optional<int>> seeds;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string key = std::to_string(i);
    const json holder = {{key, values[i]}};
    JsonObject place(holder, entry.source(), entry.path_of("seeds"));
    const int seed = place.integer(key, 0, std::numeric_limits<int>::max());
    if (std::find(seeds.begin(), seeds.end(), seed) != seeds.end()) {
      place.fail(key, std::to_string(seed) + " stands twice; remove one");
    }
    seeds.emplace_back(seed);
  }
  return seeds;
}

/// Why an entry of a type that nobody knows cannot be run: a library that could not say what types
/// it has may have this one.
std::optional<Failure> failure_of_type(const SolverRegistry& registry) {
  if (registry.unusable_libraries().empty()) return std::nullopt;
  std::string message;
  for (const SolverRegistry::UnusableLibrary& library : registry.unusable_libraries()) {
    message += (message.empty() ? "" : "; ") + library.file.string() + " " + library.how +
               " when it was loaded";
  }
  return Failure{"failed", message};
}

/// Empty where it is none; the entry's reader says so.
std::string type_in(const JsonObject& entry) {
  const json& value = entry.value();
  return value.contains("type") && value.at("type").is_string()
             ? value.at("type").get<std::string>()
             : "";
}

/// One entry of the file, and all that it stands for.
class EntryReader {
 public:
  /// `number`: of this entry among those of its type that have no label, from 1.
  EntryReader(JsonObject object, int number, SolverRegistry& registry, SolverCheck check)
      : object_(std::move(object)), number_(number), registry_(registry), check_(check) {}

  /// An entry for each seed at each point of the sweep, and what of its values stands elsewhere.
  std::vector<std::pair<SolverEntry, std::vector<Moved>>> read() {
    type_ = object_.text("type");
    const std::string label =
        object_.text_or("label", number_ == 1 ? type_ : type_ + "-" + std::to_string(number_));
    const std::string family = object_.text_or("family", label);
    if (object_.has("family") && !is_label(family)) {
      object_.fail("family", "must be made of the same characters as a label, got \"" +
                                 printable(family) + "\"");
    }
    const bool check = check_ == SolverCheck::all;
    const SolverInfo* info = check ? registry_.find(type_) : registry_.find_known(type_);
    const std::vector<std::optional<int>> seeds = read_seeds(object_, type_, info);
    std::vector<std::pair<SolverEntry, std::vector<Moved>>> entries;
    for (const SweepPoint& point : read_sweep(object_, info)) {
      for (std::size_t s = 0; s < seeds.size(); ++s) {
        SolverEntry entry = make(point, seeds[s]);
        entry.family = family;
        entry.label = label + point.label;
        if (info) describe(entry, *info);
        entries.emplace_back(std::move(entry), moved(point, s));
      }
    }
    return entries;
  }

 private:
  SolverEntry make(const SweepPoint& point, std::optional<int> seed) const {
    SolverEntry entry;
    entry.type = type_;
    entry.path = object_.path_of("");
    entry.seed = seed;
    entry.sweep = point.values;
    json spec = object_.value();
    spec.erase("seeds");
    spec.erase("sweep");
    spec.erase("family");
    if (point.values) spec.update(*point.values);
    if (seed) spec["seed"] = *seed;
    entry.spec = std::move(spec);
    return entry;
  }

  std::vector<Moved> moved(const SweepPoint& point, std::size_t seed) const {
    std::vector<Moved> out = {
        {object_.path_of("seed"), object_.path_of("seeds") + "/" + std::to_string(seed)}};
    if (!point.values) return out;
    std::size_t i = 0;
    for (const auto& [name, unused] : point.values->items()) {
      const JsonObject sweep(*point.values, "", object_.path_of("sweep"));
      out.push_back(
          {object_.path_of(name), sweep.path_of(name) + "/" + std::to_string(point.indices[i++])});
    }
    return out;
  }

  JsonObject object_;
  int number_;
  SolverRegistry& registry_;
  SolverCheck check_;
  std::string type_;
};

}  // namespace

void describe(SolverEntry& entry, const SolverInfo& info) {
  entry.inference_parameters.clear();
  entry.file_parameters.clear();
  for (const ParameterInfo& parameter : info.parameters) {
    if (parameter.role == ParameterRole::inference) {
      entry.inference_parameters.push_back(parameter.name);
    }
    if (parameter.role == ParameterRole::file) entry.file_parameters.push_back(parameter.name);
  }
  entry.break_even_reference = info.break_even_reference;
}

std::vector<SolverEntry> read_solvers(JsonObject& root, const Experiment& experiment,
                                      SolverRegistry& registry, SolverCheck check) {
  std::vector<SolverEntry> all;
  std::vector<std::vector<Moved>> moved;  // of each
  // Labels, and names of files.
  std::set<std::string> taken = {"truth", "no-contact", "limit-oracle", "limit-fair"};
  std::map<std::string, int> unlabelled;  // by type
  for (const JsonObject& object : root.objects("solvers")) {
    const SolverEntry* previous = nullptr;
    const int number = object.value().contains("label") ? 1 : ++unlabelled[type_in(object)];
    auto entries = EntryReader(object, number, registry, check).read();
    for (auto& [entry, unused] : entries) {
      if (!is_label(entry.label)) {
        object.fail("label",
                    "must be made of letters, digits, spaces and any of . _ + = , - "
                    "(at most 60, with the values of a sweep), got \"" +
                        entry.label + "\"");
      }
      const bool next_seed = entry.seed && previous && previous->label == entry.label;
      bool free = next_seed || taken.insert(entry.label).second;
      if (entry.seed) free = taken.insert(entry.stem()).second && free;
      if (!free) {
        object.fail("label",
                    "\"" + printable(entry.label) + "\" is taken; give every solver its own label");
      }
      previous = &entry;
    }
    for (auto& [entry, places] : entries) {
      all.push_back(std::move(entry));
      moved.push_back(std::move(places));
    }
  }
  if (all.empty()) root.fail("solvers", "must hold at least one solver");
  if (check == SolverCheck::none) return all;
  std::vector<EntryToCheck> to_check;
  for (std::size_t i = 0; i < all.size(); ++i) {
    // An unknown type is refused by the check, unless there is a library that may have it; a plugin
    // of ours that is absent is its trial's failure.
    if (!registry.find_known(all[i].type) && registry.is_of_plugin(all[i].type)) continue;
    if (!registry.find_known(all[i].type)) all[i].failure = failure_of_type(registry);
    if (!all[i].failure) to_check.push_back({&all[i], std::move(moved[i])});
  }
  check_entries(to_check, experiment, registry);
  return all;
}

}  // namespace ertbench
