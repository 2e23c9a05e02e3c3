#include "bench/record/record_file.h"

#include <H5public.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

#include "bench/record/cache.h"
#include "bench/score/metrics.h"
#include "core/checksum.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/text.h"
#include "forward/data/data_probes.h"
#include "solvers/registry/solver_probe.h"

namespace ertbench {

const char* name_of(Reuse reuse) {
  constexpr const char* names[] = {"same-code", "same-program", "clean"};
  return names[static_cast<std::size_t>(reuse)];
}

Reuse reuse_from_name(const std::string& name) {
  for (const Reuse reuse : {Reuse::same_code, Reuse::same_program, Reuse::clean}) {
    if (name == name_of(reuse)) return reuse;
  }
  throw InputError("--reuse: must be same-code, same-program or clean, got \"" + printable(name) +
                   "\"");
}

std::string why_stale(const std::optional<BuildStamp>& made, const BuildStamp& now, Reuse reuse) {
  if (!made) return "it does not say which build made it";
  const std::string by = " (commit " + made->commit_text() + ")";
  if (std::string differs = probe_difference(made->probes, now.probes); !differs.empty()) {
    return differs + by;
  }
  if (made->plugins != now.plugins) return "the solver libraries have changed" + by;
  if (made->program == now.program) return "";
  if (reuse == Reuse::same_program) {
    return "it was made by another program" + by;
  }
  if (reuse == Reuse::clean && (made->dirty || made->commit == "unknown")) {
    return "it was made by a build whose sources were not committed" + by;
  }
  return "";
}

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string joined(int a, int b, int c) {
  return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

constexpr double pause_s = 0.5;
constexpr double longest_s = 1e9;  ///< more is no time that anybody would wait for

fs::path progress_aside(const fs::path& file) {
  fs::path aside = file;
  return aside += ".tmp";
}

/// True if frames are worsened, whose faults the front then sees.
bool has_faults(const Experiment& experiment) {
  const auto sets = experiment.datasets();
  const auto& studies = experiment.studies;
  return experiment.ladders ||
         std::ranges::any_of(sets, [](const auto* set) { return set->faults.any(); }) ||
         std::ranges::any_of(studies,
                             [](const StudySpec& study) { return study.type == "arm_hour"; });
}

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string host_name() {
  utsname system{};
  ::uname(&system);
  return system.nodename;
}

std::string cpu_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const auto colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  return "unknown";
}

json machine_provenance() {
  utsname system{};
  ::uname(&system);
  const BuildStamp build = stamp_of_this_build();
  return {{"commit", build.commit},
          {"dirty", build.dirty},
          {"program", build.program},
          {"host", system.nodename},
          {"system", std::string(system.sysname) + " " + system.release},
          {"cpu", cpu_name()},
          {"cores", std::thread::hardware_concurrency()},
          {"compiler", "g++ " __VERSION__},
          {"libraries",
           {{"eigen", joined(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
            {"hdf5", joined(H5_VERS_MAJOR, H5_VERS_MINOR, H5_VERS_RELEASE)},
            {"nlohmann_json", joined(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                                     NLOHMANN_JSON_VERSION_PATCH)}}},
          {"date", utc_now()}};
}

json provenance(const Experiment& experiment, int jobs, const DateRange& measured) {
  json seeds = json::object();
  json datasets = json::object();
  for (const DatasetSpec* spec : experiment.datasets()) {
    seeds[spec->name] = spec->seed;
    datasets[spec->name] = to_json(*spec);
  }
  json out = machine_provenance();
  out["rendered"] = out.at("date");
  if (!measured.last.empty()) {
    out["date"] = measured.last;
    out["measured"] = {{"first", measured.first}, {"last", measured.last}};
  }
  if (!experiment.overrides.empty()) out["set"] = experiment.overrides;
  out["threads"] = 1;
  out["jobs"] = jobs;
  out["seeds"] = seeds;
  out["datasets"] = datasets;
  return out;
}

ProgressFile::ProgressFile(fs::path file) : file_(std::move(file)) {}

ProgressFile::~ProgressFile() { remove_progress(file_); }

void ProgressFile::update(std::uint64_t done, std::uint64_t total, const std::string& text) {
  if (!start_) {
    start_ = SteadyClock::now();
    first_done_ = done;
  } else if (seconds_since(last_) < pause_s) {
    return;
  }
  last_ = SteadyClock::now();
  double left = 0;
  if (done > first_done_ && done < total) {
    left = std::min(longest_s, seconds_since(*start_) * static_cast<double>(total - done) /
                                   static_cast<double>(done - first_done_));
  }
  const double fraction =
      total > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total)) : 0;
  const json content = {{"fraction", fraction}, {"text", text}, {"seconds_left", left}};
  // Renamed into place but not forced to the disk: it is of no use after a power cut.
  std::ofstream out(progress_aside(file_));
  out << json_text(content);
  out.close();
  std::error_code ignored;
  if (out) fs::rename(progress_aside(file_), file_, ignored);
}

void remove_progress(const fs::path& file) {
  std::error_code ignored;
  fs::remove(file, ignored);
  fs::remove(progress_aside(file), ignored);
}

std::optional<TrialProgress> read_progress(const fs::path& file) {
  try {
    const json content = read_json_file(file);
    JsonObject object(content, file.string(), "");
    TrialProgress progress;
    progress.fraction = object.number("fraction", {0, 1});
    if (!object.raw("text").is_string()) return std::nullopt;
    progress.text = printable(object.raw("text").get_ref<const std::string&>());
    progress.seconds_left = object.number("seconds_left", {0, longest_s});
    return progress;
  } catch (const InputError&) {
    return std::nullopt;  // not there, or not written by us
  }
}

fs::path record_file(const fs::path& folder, const std::string& job, const std::string& ending) {
  return folder / "records" / (job + ending);
}

void write_record(const fs::path& file, json record, const std::string& key,
                  const BuildStamp& build) {
  record["key"] = key;
  record["build"] = to_json(build);
  record["date"] = utc_now();
  add_checksum(record);
  write_file_atomically(file, json_text(record));
}

FoundRecord find_record(const fs::path& file, const std::string& key, const BuildStamp& now,
                        Reuse reuse) {
  if (!fs::exists(file)) return {};
  try {
    json record = read_json_file(file, most_record_bytes);
    if (const std::string changed = take_checksum(record); !changed.empty()) {
      return {JsonValue(), changed};
    }
    if (record.at("key") != key) return {JsonValue(), "it is of other settings"};
    std::string why = why_stale(build_stamp_from_json(record.value("build", json())), now, reuse);
    if (why.empty() && record.contains("fit_build")) {
      const std::optional<BuildStamp> fitted = build_stamp_from_json(record.at("fit_build"));
      BuildStamp fits = now;
      std::erase_if(fits.probes, [&](const auto& probe) {
        return fitted && !fitted->probes.empty() && !fitted->probes.contains(probe.first);
      });
      why = why_stale(fitted, fits, reuse);
      if (!why.empty()) why = "of its fitted solver: " + why;
    }
    if (!why.empty()) return {JsonValue(), why};
    return {JsonValue(std::move(record)), ""};
  } catch (const std::exception& error) {
    return {JsonValue(), std::string("it cannot be read: ") + error.what()};
  }
}

BuildStamp stamp_of_dataset(const DatasetSpec& spec) {
  return stamp_of_this_build(data_probes(spec));
}

BuildStamp stamp_of_fit(const FitRecipe& recipe) {
  Probes probes = solver_probes(recipe.entry.type);
  for (const auto* set : {&recipe.training, &recipe.validation}) {
    if (*set) probes.merge(data_probes(**set));
  }
  return stamp_of_this_build(std::move(probes), recipe.plugins);
}

BuildStamp stamp_of_record(const Experiment& experiment, const SolverEntry* entry) {
  Probes probes = {{"scores", score_probe()}};
  for (const DatasetSpec* spec : experiment.datasets()) probes.merge(data_probes(*spec));
  if (entry) probes.merge(solver_probes(entry->type));
  if (entry && has_faults(experiment)) probes["front"] = front_probe();
  return stamp_of_this_build(std::move(probes), experiment.plugins);
}

BuildStamp stamp_of_limit(const DatasetSpec& set, const DatasetSpec& scenes) {
  Probes probes = data_probes(set);
  probes.merge(data_probes(scenes));
  if (has_cached_probe("limit")) probes["limit"] = cached_probe("limit", {});
  return stamp_of_this_build(std::move(probes));
}

Probes all_probes() {
  Probes out = all_data_probes();
  out.merge(all_solver_probes());
  out["scores"] = score_probe();
  out["front"] = front_probe();
  return out;
}

Probes current_probes(const BuildStamp& made) {
  Probes out;
  const Probes data = all_data_probes();
  for (const auto& [name, probe] : made.probes) {
    const auto found = data.find(name);
    if (found != data.end()) out.insert(*found);
    if (name == "front") out[name] = front_probe();
    if (name.starts_with("solver/")) out.merge(solver_probes(name.substr(7)));
  }
  return out;
}

}  // namespace ertbench
