#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/cli/command.h"
#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/run/timing_stage.h"
#include "bench/score/metrics.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/text.h"
#include "forward/data/generate.h"
#include "solvers/check/stored_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct GenerateArguments {
  std::string experiment;
  std::string dataset;
  std::string out;
};

ExitCode generate(const GenerateArguments& arguments) {
  SolverRegistry registry;
  const Experiment experiment = read_experiment(arguments.experiment, registry, chart_types());
  const Cache cache = Cache::standard();
  const CacheShare share(cache, CacheShare::Of::run);
  if (arguments.dataset.empty() && arguments.out.empty()) {
    ensure_datasets(experiment, cache);
    for (const DatasetSpec* spec : experiment.datasets()) {
      std::printf("%s: %s\n", spec->name.c_str(),
                  printable_path(cache.dataset(*spec).string()).c_str());
    }
    return done;
  }
  const std::vector<const DatasetSpec*> sets = experiment.datasets();
  std::string name = arguments.dataset;
  if (name.empty() && sets.size() == 1) name = sets.front()->name;
  const DatasetSpec* spec = experiment.find_dataset(name);
  if (!spec) {
    throw InputError("--dataset: must name one of the datasets of " + arguments.experiment + ": " +
                     joined(sets, ", ", &DatasetSpec::name) +
                     (name.empty() ? "" : "; got \"" + printable(name) + "\""));
  }
  const std::filesystem::path file =
      arguments.out.empty() ? cache.dataset(*spec) : std::filesystem::path(arguments.out);
  if (arguments.out.empty()) {
    std::filesystem::create_directories(file.parent_path());
  } else {
    std::vector<std::filesystem::path> inputs = experiment.plugins;
    inputs.insert(inputs.end(), experiment.files.begin(), experiment.files.end());
    require_dataset_output(file, inputs);
  }
  Progress progress("generating \"" + name + "\"");
  generate_dataset(*spec, file, {usable_cores(), [&](std::uint64_t written, std::uint64_t total) {
                                   progress.update(written, total);
                                 }});
  std::printf("%s: %llu scenes in %s\n", name.c_str(), static_cast<unsigned long long>(spec->count),
              printable_path(file.string()).c_str());
  warn_of_missed_promise(*spec, file);
  return done;
}

struct CacheArguments {
  bool prune = false;
  bool all = false;
  bool stale = false;
  bool dry_run = false;
  std::optional<double> older_than;
};

std::string megabytes(std::uint64_t bytes) {
  return fixed(static_cast<double>(bytes) / (1 << 20), 1) + " MB";
}

bool is_chosen(const CachedThing& thing, const CacheArguments& arguments) {
  if (thing.in_use) return false;
  return arguments.all || (arguments.stale && thing.stale) ||
         (arguments.older_than && thing.age_days > *arguments.older_than);
}

std::string line_of(const CachedThing& thing) {
  return thing.kind + "  " + printable_path(thing.file.filename().string()) + "  " +
         megabytes(thing.bytes) + ", " + fixed(thing.age_days, 1) + " days old, commit " +
         printable(thing.commit) + (thing.stale ? ", no longer what this program makes" : "") +
         (thing.in_use ? ", in use" : "");
}

ExitCode cache(const CacheArguments& arguments) {
  const Cache cache = Cache::standard();
  if (arguments.prune && !arguments.all && !arguments.stale && !arguments.older_than) {
    throw InputError("--prune: say what: --stale, --older-than DAYS, or --all");
  }
  std::optional<CacheShare> share;
  if (arguments.prune && !arguments.dry_run) share.emplace(cache, CacheShare::Of::removal);
  std::uint64_t bytes = 0;
  std::size_t count = 0;
  for (const CachedThing& thing : cache_contents(cache)) {
    if (arguments.prune && !is_chosen(thing, arguments)) continue;
    if (arguments.prune && !arguments.dry_run) remove_cached(thing);
    std::printf("%s\n", line_of(thing).c_str());
    bytes += thing.bytes;
    ++count;
  }
  const char* what = !arguments.prune ? "" : arguments.dry_run ? " would be removed" : " removed";
  std::printf("%s: %zu datasets and solvers%s, %s\n",
              printable_path(cache.folder().string()).c_str(), count, what,
              megabytes(bytes).c_str());
  return done;
}

constexpr std::size_t most_described = 1000;  ///< characters of a plugin's own words

struct ListArguments {
  std::string type;
  std::string schema;
  bool as_json = false;
  bool fitted = false;
};

/// The card's row in the table of fitted solvers, and what it says below.
void add_card(const std::string& name, TableSection& section) {
  const fs::path file = stored_solver_file(name, ".json");
  const json content = read_json_file(file);
  JsonObject card(content, file.string(), "");
  JsonObject error = card.object("relative_error");
  const std::vector<double> ci95 = error.numbers("ci95", 2);
  JsonObject latency = card.object("latency_us");
  const bool busy = latency.object("machine").number("busy_cores") >= least_disturbing_cores;
  section.rows.push_back(
      {name, printable(card.text("type")),
       fixed(error.number("mean"), 3) + " " + interval_text(fixed(ci95[0], 3), fixed(ci95[1], 3)),
       time_text(latency.number("p50")) + " / " + time_text(latency.number("p99")) +
           (busy ? " *" : ""),
       fixed(static_cast<double>(fs::file_size(stored_solver_file(name))) / 1000, 0)});
  section.notes.push_back(
      name + ": " + printable(card.text("trained_on"), most_described) +
      ". Fails beyond: " + printable(card.text("fails_beyond"), most_described) + ".");
}

void print_fitted() {
  TableSection section;
  section.columns = {Column("name", Align::left), Column("method", Align::left),
                     "relative error [95 %]", "a frame, p50 / p99", "kB"};
  for (const std::string& name : stored_solver_names()) add_card(name, section);
  section.notes.emplace_back(
      "For the default sensor, by name: `--solver NAME`, in an experiment \"checkpoint\": "
      "\"NAME\". Fails: on more than 5 % of single discs. *: timed while other processes kept the "
      "machine busy, which lengthens p99 above all.");
  std::printf("%s", terminal_of({"", "", {section}, {}, ""}).c_str());
}

void print_solver(SolverRegistry& registry, const std::string& type) {
  const SolverInfo* info = registry.find(type);
  if (!info) {
    std::printf("\n  %s\n      not available: its plugin is not built\n", type.c_str());
    return;
  }
  std::printf("\n  %s\n      %s\n", type.c_str(), printable(info->summary, most_described).c_str());
  for (const ParameterInfo& parameter : info->parameters) {
    std::printf("      \"%s\": %s\n", printable(parameter.name).c_str(),
                printable(parameter.description, most_described).c_str());
  }
}

json json_of_solver(SolverRegistry& registry, const std::string& type) {
  const SolverInfo* info = registry.find(type);
  if (!info) return {{"type", type}, {"available", false}};
  json parameters = json::array();
  for (const ParameterInfo& parameter : info->parameters) {
    parameters.push_back({{"name", parameter.name},
                          {"description", parameter.description},
                          {"inference", parameter.role == ParameterRole::inference}});
  }
  return {{"type", type},
          {"available", true},
          {"summary", info->summary},
          {"seeded", info->has_seed()},
          {"parameters", parameters}};
}

std::vector<fs::path> experiment_files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(project_folder() / "experiments")) {
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") {
      files.push_back(entry.path());
    }
  }
  std::ranges::sort(files);
  return files;
}

/// Title and question of an experiment, which may be one on KTC2023's files.
std::pair<std::string, std::string> words_of(const fs::path& file, SolverRegistry& registry) {
  const ExperimentJson ktc = read_experiment_json(file);
  if (ktc.content->contains("data")) return {ktc.content->at("title"), ktc.content->at("question")};
  const Experiment experiment = read_experiment(file, registry, {}, SolverCheck::none);
  return {experiment.title, experiment.question};
}

/// The types asked for: all, or one. Throws InputError where there is no such type.
std::vector<std::string> types_of(const SolverRegistry& registry, const std::string& type) {
  std::vector<std::string> all = registry.types();
  if (type.empty()) return all;
  if (std::ranges::find(all, type) != all.end()) return {type};
  const std::string near = nearest_word(type, all);
  throw InputError("no solver has the type \"" + printable(type) + "\"" +
                   (near.empty() ? "" : "; did you mean \"" + near + "\"?") + "; there are " +
                   joined(all));
}

void print_metrics_and_experiments(SolverRegistry& registry) {
  std::printf("\nMetrics (δσ: the change of the conductivity; * may be chosen as an error):\n\n");
  for (const MetricEntry& entry : kMetricTable) {
    std::printf("  %s%s: %s\n", entry.name, is_error(entry) ? "*" : "", entry.legend);
  }
  std::printf("\nExperiments:\n");
  for (const fs::path& file : experiment_files()) {
    std::string question;
    try {
      question = words_of(file, registry).second;
    } catch (const InputError& error) {
      question = std::string("cannot be used: ") + error.what();
    }
    std::printf("\n  experiments/%s\n      %s\n", printable_path(file.filename().string()).c_str(),
                printable(question).c_str());
  }
}

void print_json(SolverRegistry& registry, const ListArguments& arguments) {
  json out = {{"solvers", json::array()}};
  for (const std::string& type : types_of(registry, arguments.type)) {
    out["solvers"].push_back(json_of_solver(registry, type));
  }
  if (arguments.type.empty()) {
    for (const MetricEntry& entry : kMetricTable) {
      out["metrics"].push_back(
          {{"name", entry.name}, {"legend", entry.legend}, {"error", is_error(entry)}});
    }
    for (const fs::path& file : experiment_files()) {
      json& entry = out["experiments"].emplace_back();
      entry["file"] = "experiments/" + file.filename().string();
      try {
        const auto [title, question] = words_of(file, registry);
        entry["title"] = title;
        entry["question"] = question;
      } catch (const InputError& error) {
        entry["error"] = error.what();
      }
    }
  }
  std::printf("%s\n", json_text(printable_json(out, most_described), 2).c_str());
}

ExitCode list(const ListArguments& arguments) {
  if (!arguments.schema.empty()) {
    write_file_atomically(arguments.schema, updated_schema(arguments.schema));
    return done;
  }
  if (arguments.fitted) {
    print_fitted();
    return done;
  }
  SolverRegistry registry;
  if (arguments.as_json) {
    print_json(registry, arguments);
    return done;
  }
  const std::vector<std::string> types = types_of(registry, arguments.type);
  std::printf("Solvers (\"type\" in an experiment's \"solvers\" list):\n");
  for (const std::string& type : types) print_solver(registry, type);
  if (arguments.type.empty()) print_metrics_and_experiments(registry);
  return done;
}

}  // namespace

Action add_generate(CLI::App& command) {
  const auto arguments = std::make_shared<GenerateArguments>();
  command.description("Write the datasets of an experiment");
  add_experiment(command, arguments->experiment);
  command.add_option("--dataset", arguments->dataset,
                     "Only this one (default: all, into the cache)");
  command.add_option("--out", arguments->out,
                     "HDF5 file to write (default: in the cache); of what is there,\n"
                     "only a dataset is written over");
  command.footer(
      "Example:\n  ertbench generate experiments/table_c1.json --dataset test --out test.h5\n"
      "A run that was cut off goes on where it stopped when the same command is given again.");
  return [arguments] { return generate(*arguments); };
}

Action add_cache(CLI::App& command) {
  const auto arguments = std::make_shared<CacheArguments>();
  command.description("List the datasets and fitted solvers that are kept, or remove some");
  auto* prune = command.add_flag("--prune", arguments->prune,
                                 "Remove what the other options\nchoose, while no run needs it");
  command.add_flag("--stale", arguments->stale, "Those whose probes are no longer this program's")
      ->needs(prune);
  command.add_option("--older-than", arguments->older_than, "Written so many days ago")
      ->check(CLI::Range(0.0, 1e6))
      ->needs(prune);
  command.add_flag("--all", arguments->all, "All of it")->needs(prune);
  command.add_flag("--dry-run", arguments->dry_run, "Only say what would be removed")->needs(prune);
  command.footer(
      "Example:\n  ertbench cache --prune --stale --older-than 30\n"
      "The cache is the folder cache/ of the project, or $ERTBENCH_CACHE. Whatever is in it can\n"
      "be made again; a training may take hours.");
  return [arguments] { return cache(*arguments); };
}

Action add_list(CLI::App& command) {
  const auto arguments = std::make_shared<ListArguments>();
  command.description("Solvers with their parameters; metrics; experiments; fitted solvers");
  command.add_option("TYPE", arguments->type, "Only the solver of this type");
  CLI::Option* json = command.add_flag("--json", arguments->as_json, "For programs");
  command
      .add_flag("--fitted", arguments->fitted,
                "The fitted solvers of results/networks, which need no training")
      ->excludes(json);
  command.add_option("--schema", arguments->schema,
                     "Bring a JSON schema, such as experiments/schema.json, up to date with\n"
                     "the program's types, ranges and defaults");
  command.footer(
      "Examples:\n  ertbench list\n  ertbench list dd-ert --json\n  ertbench list --fitted");
  return [arguments] { return list(*arguments); };
}

}  // namespace ertbench
