#include "bench/run/trial.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "bench/record/records.h"
#include "bench/run/calibration.h"
#include "bench/run/fitted_solver.h"
#include "bench/score/metric_summary.h"
#include "bench/score/metrics.h"
#include "core/atomic_file.h"
#include "core/quantile.h"
#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr std::uint64_t block_frames = 256;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

json numbers_or_null(const std::vector<FrameMetrics>& frames, Metric metric) {
  json out = json::array();
  for (const FrameMetrics& frame : frames) {
    out.push_back(frame[metric] ? json(*frame[metric]) : json());
  }
  return out;
}

/// All frames of one test set, scored.
struct Scored {
  ResultRow row;
  json frames;
  json figure_images = json::array();
};

Scored score(const Solver& solver, const DatasetFile& set, const Sensor& sensor,
             const std::vector<int>& figure_scenes) {
  std::vector<FrameMetrics> metrics;
  json statuses = json::array();
  json reasons = json::array();
  json iterations = json::array();
  json gaps = json::array();
  Scored out;
  std::map<int, json> kept;
  for (std::uint64_t first = 0; first < set.size(); first += block_frames) {
    const std::uint64_t count = std::min(block_frames, set.size() - first);
    const Frames changes =
        set.voltages(first, count).rowwise() - set.reference_voltages().transpose();
    const Images truths = set.conductivity(first, count);
    const std::vector<Scene> scenes = set.scenes(first, count);
    Images images(changes.rows(), sensor.pixels());
    std::vector<FrameReport> reports(count);
    solver.reconstruct(changes, images, reports);
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const bool usable =
          reports[i].status != FrameStatus::undefined && images.row(row).allFinite();
      metrics.push_back(usable ? frame_metrics(sensor, truths.row(row), images.row(row), scenes[i])
                               : FrameMetrics{});
      out.row.undefined_frames += !usable;
      out.row.frames_not_converged += reports[i].status == FrameStatus::not_converged;
      out.row.suspect_frames += usable && reports[i].status == FrameStatus::suspect;
      statuses.push_back(usable ? static_cast<int>(reports[i].status)
                                : static_cast<int>(FrameStatus::undefined));
      reasons.push_back(reports[i].reasons);
      iterations.push_back(reports[i].iterations);
      gaps.push_back(reports[i].gap);
      const int scene = static_cast<int>(first + i);
      if (std::find(figure_scenes.begin(), figure_scenes.end(), scene) != figure_scenes.end()) {
        const Eigen::RowVectorXd image = images.row(row);
        kept[scene] = std::vector<double>(image.begin(), image.end());
      }
    }
  }
  for (const int scene : figure_scenes) out.figure_images.push_back(kept.at(scene));
  out.row.frames = static_cast<int>(metrics.size());
  out.row.metrics = summarise(metrics);
  for (const Metric metric : kMetrics) {
    out.frames[name_of(metric)] = numbers_or_null(metrics, metric);
  }
  out.frames["status"] = std::move(statuses);
  out.frames["reasons"] = std::move(reasons);
  out.frames["iterations"] = std::move(iterations);
  out.frames["gap"] = std::move(gaps);
  return out;
}

}  // namespace

void run_accuracy_stage(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                        SolverRegistry& registry, int threads, const fs::path& folder) {
  const FittedSolver fitted =
      fitted_solver(experiment, entry, cache, registry, threads,
                    record_file(folder, entry, {Stage::accuracy}, ".progress"));
  const FitReport report = fitted.solver->fit_report();
  json record = {{"schema", record_schema},
                 {"key", record_key(experiment, entry, Stage::accuracy)},
                 {"fit_s", fitted.fit_s},
                 {"fit_report", {{"status", report.status}, {"message", report.message}}}};
  std::vector<const DatasetSpec*> sets;
  for (const DatasetSpec& test : experiment.tests) sets.push_back(&test);
  if (experiment.right_sizing) sets.push_back(&*experiment.validation);
  for (const DatasetSpec* test : sets) {
    const bool first = test == sets.front();
    const DatasetFile set(cache.dataset(*test));
    Scored scored = score(*fitted.solver, set, experiment.sensor,
                          first ? experiment.figure_scenes : std::vector<int>{});
    scored.row.label = entry.label;
    scored.row.type = entry.type;
    scored.row.dataset = test->name;
    scored.row.status = report.status;
    scored.row.message = report.message;
    scored.row.parameters_json = fitted.solver->parameters().dump();
    scored.row.fit_s = fitted.fit_s;
    record["rows"].push_back(to_json(scored.row));
    record["frames"][test->name] = std::move(scored.frames);
    if (first) record["figure_images"] = std::move(scored.figure_images);
  }
  write_file_atomically(record_file(folder, entry, {Stage::accuracy}), record.dump());
}

void run_timing_round(const Experiment& experiment, const SolverEntry& entry, const Cache& cache,
                      SolverRegistry& registry, int round, const fs::path& folder) {
  const StagePart part{Stage::timing, round};
  const FittedSolver fitted = fitted_solver(experiment, entry, cache, registry, 1,
                                            record_file(folder, entry, part, ".progress"));
  const TimingSettings& timing = experiment.timing;
  const int first = round * timing.frames / timing.rounds;
  const int last = (round + 1) * timing.frames / timing.rounds;
  json record = {{"schema", record_schema},
                 {"key", record_key(experiment, entry, Stage::timing)},
                 {"calibration_us", calibration_us()}};
  for (const DatasetSpec& test : experiment.tests) {
    const DatasetFile set(cache.dataset(test));
    const std::uint64_t available =
        std::min<std::uint64_t>(set.size(), static_cast<std::uint64_t>(timing.frames));
    const Frames voltages = set.voltages(0, available);
    const Eigen::RowVectorXd reference = set.reference_voltages().transpose();

    // One frame: from its raw voltages to the finished image.
    Frames change(1, voltages.cols());
    Images image(1, experiment.sensor.pixels());
    const auto one_frame = [&](Eigen::Index frame) {
      FrameReport report;
      change = voltages.row(frame % voltages.rows()) - reference;
      fitted.solver->reconstruct(change, image, {&report, 1});
    };
    for (int i = 0; i < timing.warm_up; ++i) one_frame(first + i);
    std::vector<double> microseconds;
    for (int i = first; i < last; ++i) {
      const Clock::time_point start = Clock::now();
      one_frame(i);
      microseconds.push_back(1e6 * seconds_since(start));
    }

    // Batches, for the round's share of a second or at least two, the first as warm-up.
    Frames batch(timing.batch, voltages.cols());
    Frames changes(timing.batch, voltages.cols());
    Images images(timing.batch, experiment.sensor.pixels());
    for (Eigen::Index i = 0; i < batch.rows(); ++i)
      batch.row(i) = voltages.row(i % voltages.rows());
    std::vector<FrameReport> reports(static_cast<std::size_t>(timing.batch));
    std::vector<double> batch_s;
    const auto one_batch = [&] {
      const Clock::time_point start = Clock::now();
      changes = batch.rowwise() - reference;
      std::fill(reports.begin(), reports.end(), FrameReport{});
      fitted.solver->reconstruct(changes, images, reports);
      return seconds_since(start);
    };
    one_batch();
    const Clock::time_point begin = Clock::now();
    do {
      batch_s.push_back(one_batch());
    } while (seconds_since(begin) < 1.0 / timing.rounds && batch_s.size() < 1000);
    record["timing"][test.name] = {{"latency_us", microseconds},
                                   {"frames_per_s", timing.batch / median(batch_s)},
                                   {"batch", timing.batch}};
  }
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  record["peak_rss_mb"] = static_cast<double>(usage.ru_maxrss) / 1024;
  write_file_atomically(record_file(folder, entry, part), record.dump());
}

}  // namespace ertbench
