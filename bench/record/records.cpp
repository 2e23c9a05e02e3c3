#include "bench/record/records.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/record/cache.h"
#include "bench/record/ladder_record.h"
#include "bench/record/provenance.h"
#include "core/json_reader.h"
#include "core/quantile.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Raised whenever the same images would score otherwise. A metric more needs no other version: the
/// key of what was scored holds the metrics' names.
constexpr int metrics_version = 1;

std::optional<json> read_record(const Experiment& experiment, const SolverEntry& entry,
                                StagePart part, const fs::path& folder) {
  const fs::path file = record_file(folder, entry, part);
  if (!fs::exists(file)) return std::nullopt;
  try {
    json record = read_json_file(file);
    if (record.at("key") == record_key(experiment, entry, part.stage)) return record;
  } catch (const std::exception&) {  // not a record of ours: made again
  }
  return std::nullopt;
}

ScoredSet scored_set(const json& row, const json& frames, const std::string& source) {
  ScoredSet set;
  set.row = result_row_from_json(JsonObject(row, source, "/rows"));
  for (const json& status : frames.at("status")) {
    set.statuses.push_back(static_cast<FrameStatus>(status.get<int>()));
  }
  set.frames.resize(set.statuses.size());
  for (const Metric metric : kMetrics) {
    if (!frames.contains(name_of(metric))) continue;  // written before there was this metric
    const json& values = frames.at(name_of(metric));
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      if (!values.at(i).is_null()) set.frames[i][metric] = values[i].get<double>();
    }
  }
  return set;
}

Images images_from(const json& rows, int pixels) {
  Images images(static_cast<Eigen::Index>(rows.size()), pixels);
  for (Eigen::Index i = 0; i < images.rows(); ++i) {
    for (Eigen::Index p = 0; p < pixels; ++p) {
      const json& value = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(p));
      images(i, p) = value.is_null() ? std::nan("") : value.get<double>();
    }
  }
  return images;
}

/// p50, p99 and maximum of every frame's time. A percentile is a time that was measured.
LatencySummary summarise_latency(const SortedValues& microseconds) {
  return {nearest_rank_quantile(microseconds, 0.5),
          nearest_rank_quantile(microseconds, 0.99),
          microseconds.largest(),
          {}};
}

}  // namespace

const char* name_of(Stage stage) {
  switch (stage) {
    case Stage::accuracy:
      return "accuracy";
    case Stage::timing:
      return "timing";
    case Stage::ladders:
      return "ladders";
  }
  return "";
}

std::string record_key(const Experiment& experiment, const SolverEntry& entry, Stage stage) {
  json key = {{"schema", record_schema},
              {"metrics", metrics_version},
              {"label", entry.label},
              {"entry", entry.spec.text()},
              {"solver", Cache::fitted_solver_key(fit_recipe(experiment, entry)).dump()}};
  for (const DatasetSpec& test : experiment.tests) key["tests"].push_back(to_json(test));
  if (stage == Stage::accuracy) {
    key["scored"] = names_of(kMetrics);  // a record without one of them is made again
    if (experiment.right_sizing) key["validation"] = true;
    key["figure"] = experiment.figure_scenes;
  } else {
    const TimingSettings& timing = experiment.timing;
    key["timing"] = {timing.frames, timing.warm_up, timing.batch, timing.rounds};
    key["cpu"] = cpu_name();
  }
  return hash_of(key.dump());
}

fs::path record_file(const fs::path& folder, const SolverEntry& entry, StagePart part,
                     const std::string& ending) {
  std::string name = entry.stem() + "." + name_of(part.stage);
  if (part.stage == Stage::timing) name += "." + std::to_string(part.round);
  return folder / "records" / (name + ending);
}

std::optional<AccuracyRecord> read_accuracy_record(const Experiment& experiment,
                                                   const SolverEntry& entry,
                                                   const fs::path& folder) {
  const auto json_record = read_record(experiment, entry, {Stage::accuracy}, folder);
  if (!json_record) return std::nullopt;
  try {
    AccuracyRecord record;
    const std::string source = record_file(folder, entry, {Stage::accuracy}).string();
    for (const json& row : json_record->at("rows")) {
      const json& frames = json_record->at("frames").at(row.at("dataset").get<std::string>());
      record.sets.push_back(scored_set(row, frames, source));
    }
    if (experiment.right_sizing) {
      record.validation = std::move(record.sets.back());
      record.sets.pop_back();
    }
    record.figure_images =
        images_from(json_record->at("figure_images"), experiment.sensor.pixels());
    return record;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

std::optional<TimingRecord> read_timing_record(const Experiment& experiment,
                                               const SolverEntry& entry, const fs::path& folder) {
  struct Measured {
    std::vector<double> microseconds;
    std::vector<double> p50;
    std::vector<double> frames_per_s;
    int batch = 0;
  };
  std::map<std::string, Measured> sets;
  std::vector<double> calibration;
  TimingRecord record;
  for (int round = 0; round < experiment.timing.rounds; ++round) {
    const auto part = read_record(experiment, entry, {Stage::timing, round}, folder);
    if (!part) return std::nullopt;
    try {
      for (const auto& [dataset, times] : part->at("timing").items()) {
        Measured& set = sets[dataset];
        const auto microseconds = times.at("latency_us").get<std::vector<double>>();
        set.p50.push_back(summarise_latency(microseconds).p50);
        set.microseconds.insert(set.microseconds.end(), microseconds.begin(), microseconds.end());
        set.frames_per_s.push_back(times.at("frames_per_s").get<double>());
        set.batch = times.at("batch").get<int>();
      }
      calibration.push_back(part->at("calibration_us").get<double>());
      record.peak_rss_mb = std::max(record.peak_rss_mb, part->at("peak_rss_mb").get<double>());
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }
  for (auto& [dataset, set] : sets) {
    MeasuredTimes times{summarise_latency(set.microseconds), median(set.frames_per_s), set.batch};
    times.latency_us.p50_of_rounds = set.p50;
    record.sets[dataset] = std::move(times);
  }
  record.calibration_us = median(calibration);
  return record;
}

bool has_record(const Experiment& experiment, const SolverEntry& entry, StagePart part,
                const fs::path& folder) {
  switch (part.stage) {
    case Stage::accuracy:
      return read_accuracy_record(experiment, entry, folder).has_value();
    case Stage::timing:
      return read_record(experiment, entry, part, folder).has_value();
    case Stage::ladders:
      return read_ladder_record(experiment, entry, folder).has_value();
  }
  return false;
}

}  // namespace ertbench
