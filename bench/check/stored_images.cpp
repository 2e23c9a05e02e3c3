#include "bench/check/stored_images.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/check/tolerance.h"
#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "bench/features/features.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double image_limit_s = 120;

double difference(const fs::path& before, const fs::path& now) {
  const Hdf5File a = Hdf5File::open(before);
  const Hdf5File b = Hdf5File::open(now);
  const auto shape = a.shape("/conductivity_change");
  const bool same = b.shape("/conductivity_change") == shape &&
                    a.read_vector("/status") == b.read_vector("/status");
  if (!same) return std::numeric_limits<double>::infinity();
  const RowMajorMatrix images = a.read_rows("/conductivity_change", 0, shape[0]);
  const RowMajorMatrix changes = b.read_rows("/conductivity_change", 0, shape[0]) - images;
  return (changes.rowwise().norm().array() / images.rowwise().norm().array()).maxCoeff();
}

/// Makes today's images in a child process; returns false if it failed.
bool make_images(const StoredImages& images) {
  fs::create_directories(images.now.parent_path());
  fs::remove(images.now);
  ChildProcess process(
      {fs::read_symlink("/proc/self/exe").string(), "reconstruct", "--solver", images.spec.string(),
       "--input", images.frames.string(), "--output", images.now.string()},
      {images.log}, {image_limit_s});
  return process.wait().ok();
}

/// A line with the largest relative difference (2-norm) of a frame's image, infinite if frames or
/// statuses differ. It is "worse" beyond `most` or without today's images, "missing" without stored
/// ones. Throws InputError if the stored images cannot be read.
CheckLine compare_one(const std::string& row, const StoredImages& images) {
  CheckLine line{row, "images", "0", "", with_digits(images.most, 2), Verdict::worse};
  if (!fs::exists(images.now)) {
    line.now = "failed; see " + images.log.string();
    return line;
  }
  if (!fs::exists(images.before)) {
    line.before = "-";
    line.verdict = Verdict::missing;
    return line;
  }
  const double change = difference(images.before, images.now);
  line.now = with_digits(change, 2);
  if (change <= images.most) line.verdict = Verdict::ok;
  return line;
}

std::vector<fs::path> specifications(const fs::path& folder, const std::set<std::string>& types) {
  std::vector<fs::path> out;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(folder, absent)) {
    if (entry.path().extension() != ".json") continue;
    const json spec = read_json_file(entry.path());
    if (types.count(JsonObject(spec, entry.path().string(), "").text("type"))) {
      out.push_back(entry.path());
    }
  }
  std::ranges::sort(out);
  return out;
}

/// The entry with at least `count` seeds: its own, then the smallest other numbers.
json with_seeds(json entry, int count) {
  json seeds = entry.contains("seeds") ? entry.at("seeds") : json::array();
  if (entry.contains("seed")) seeds.push_back(entry.at("seed"));
  for (int seed = 1; seeds.size() < static_cast<std::size_t>(count); ++seed) {
    if (std::find(seeds.begin(), seeds.end(), seed) == seeds.end()) seeds.push_back(seed);
  }
  entry.erase("seed");
  entry["seeds"] = std::move(seeds);
  return entry;
}

/// True if the entry, which may be a sweep, makes a row of one of the labels.
bool makes_row(const Experiment& experiment, std::size_t entry,
               const std::set<std::string>& labels) {
  const std::string path = "/solvers/" + std::to_string(entry);
  return std::ranges::any_of(experiment.solvers, [&](const SolverEntry& one) {
    return one.path == path && labels.count(one.label) > 0;
  });
}

/// Replaces all but the times, which stay those of the experiment's own run.
void take_over_seeds(const ResultRow& trained, ResultRow& row) {
  row.metrics = trained.metrics;
  row.seeds = trained.seeds;
  if (trained.ok()) return;
  row.status = trained.status;
  row.message = trained.message;
}

}  // namespace

std::vector<StoredImages> stored_networks(const fs::path& folder,
                                          const std::set<std::string>& types, const fs::path& out) {
  std::vector<StoredImages> networks;
  for (const fs::path& spec : specifications(folder, types)) {
    const std::string name = spec.stem().string();
    networks.push_back({name, spec, folder / "frames.h5", folder / (name + ".images.h5"),
                        out / (name + ".images.h5"), out / (name + ".log"),
                        stored_image_tolerance});
  }
  std::ranges::for_each(networks, make_images);
  return networks;
}

std::vector<StoredImages> short_trainings(const fs::path& folder,
                                          const std::set<std::string>& types, const Cache& cache,
                                          const fs::path& out, int jobs) {
  const fs::path file = folder / "experiment.json";
  if (!fs::exists(file)) return {};
  SolverRegistry registry;
  const Experiment experiment = read_experiment(file, registry, {});
  RunOptions options;
  options.out = out;
  options.jobs = jobs;
  std::vector<StoredImages> trainings;
  for (const SolverEntry& entry : experiment.solvers) {
    if (types.count(entry.type) == 0) continue;
    options.only.push_back(entry.label);
    const fs::path spec = out / (entry.label + ".json");
    trainings.push_back({entry.label, spec, cache.dataset(experiment.tests.front()),
                         folder / (entry.label + ".images.h5"), out / (entry.label + ".images.h5"),
                         out / (entry.label + ".log"), short_training_tolerance});
    const json solver = {
        {"type", entry.type},
        {"checkpoint", fs::absolute(cache.fitted_solver(fit_recipe(experiment, entry))).string()}};
    fs::create_directories(out);
    write_file_atomically(spec, json_text(solver) + "\n");
  }
  if (trainings.empty()) return {};
  run_experiment(experiment, cache, options);
  std::ranges::for_each(trainings, make_images);
  return trainings;
}

std::vector<CheckLine> compare_images(const std::string& kind,
                                      const std::vector<StoredImages>& images,
                                      const std::vector<std::string>& expected) {
  std::vector<CheckLine> lines;
  for (const StoredImages& one : images) lines.push_back(compare_one(kind + " " + one.name, one));
  for (const std::string& name : expected) {
    if (std::ranges::find(images, name, &StoredImages::name) == images.end()) {
      lines.push_back({kind + " " + name, "images", "-", "-", "", Verdict::missing});
    }
  }
  return lines;
}

bool store_trainings(const std::vector<StoredImages>& trainings) {
  const bool all =
      std::ranges::all_of(trainings, [](const StoredImages& one) { return fs::exists(one.now); });
  if (!all) return false;
  for (const StoredImages& one : trainings) {
    replace_file(one.before, [&](const fs::path& aside) { fs::copy_file(one.now, aside); });
  }
  return true;
}

std::vector<std::string> overrides_for_seeds(const Experiment& experiment,
                                             const std::set<std::string>& labels, int count) {
  const ExperimentJson read = read_experiment_json(experiment.file, experiment.overrides);
  const json& entries = read.content->at("solvers");
  json solvers = json::array();
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (makes_row(experiment, i, labels)) solvers.push_back(with_seeds(entries[i], count));
  }
  std::vector<std::string> out = experiment.overrides;
  out.push_back("solvers=" + solvers.dump());
  out.emplace_back("timing.enabled=false");
  out.emplace_back("figure.scenes=[]");
  // Stages that take long and that no score depends on.
  for (const char* key : {"studies", "charts", "ladders", "folds", "right_sizing"}) {
    if (read.content->contains(key)) out.push_back(std::string(key) + "=null");
  }
  return out;
}

int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows) {
  std::set<std::string> few;
  for (const ResultRow& row : rows) {
    const bool enough = row.seeds && std::ssize(row.seeds->values) >= count;
    if (labels.count(row.label) > 0 && !enough) few.insert(row.label);
  }
  if (few.empty()) return 0;
  RunOptions seeds = options;
  seeds.out = options.out / "seeds";
  fs::create_directories(seeds.out);
  SolverRegistry registry;  // without loaded plugins
  const Experiment again =
      read_experiment(experiment.file, registry, chart_types(), SolverCheck::all,
                      overrides_for_seeds(experiment, few, count));
  const ExperimentResults results = run_experiment(again, cache, seeds);
  report_experiment(again, cache, results, seeds.out);
  for (const ResultRow& trained : read_summary_rows(seeds.out)) {
    for (ResultRow& row : rows) {
      if (few.count(row.label) > 0 && row.label == trained.label && row.dataset == trained.dataset)
        take_over_seeds(trained, row);
    }
  }
  return results.failures;
}

std::vector<ResultRow> read_summary_rows(const fs::path& folder) {
  const fs::path file = folder / "summary.json";
  const json summary = read_json_file(file);
  JsonObject root(summary, file.string(), "");
  std::vector<ResultRow> rows;
  for (const JsonObject& row : root.objects("rows")) rows.push_back(result_row_from_json(row));
  return rows;
}

}  // namespace ertbench
