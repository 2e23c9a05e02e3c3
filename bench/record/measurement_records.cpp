#include "bench/record/measurement_records.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "core/json.h"
#include "core/statistics.h"

namespace ertbench {
namespace {

using nlohmann::json;

json value_or_null(const std::optional<double>& value) { return value ? json(*value) : json(); }

json place_or_null(const std::optional<Eigen::Vector2d>& place) {
  return place ? json{place->x(), place->y()} : json();
}

std::optional<double> value_from(const json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}

std::optional<Eigen::Vector2d> place_from(const json& place) {
  if (place.is_null()) return std::nullopt;
  return Eigen::Vector2d(place.at(0).get<double>(), place.at(1).get<double>());
}

ContactReading contact_from(const json& contact) {
  const auto number = [&](std::size_t i) { return contact.at(i).get<double>(); };
  return {{number(0), number(1)}, number(2), number(3), number(4)};
}

FrameReading reading_from(const json& frame) {
  FrameReading out;
  for (const json& contact : frame.at("contacts")) out.contacts.push_back(contact_from(contact));
  out.peak = value_from(frame.at("peak"));
  out.sum = value_from(frame.at("sum"));
  out.centroid_mm = place_from(frame.at("centroid_mm"));
  out.centroid25_mm = place_from(frame.at("centroid25_mm"));
  out.explained = value_from(frame.at("explained"));
  return out;
}

ScoredSet scored_set(const json& row, const json& frames, const std::string& source) {
  ScoredSet set;
  set.row = result_row_from_json(JsonObject(row, source, "/rows"));
  for (const json& status : frames.at("status")) {
    set.statuses.push_back(static_cast<FrameStatus>(status.get<int>()));
  }
  set.frames.resize(set.statuses.size());
  for (const Metric metric : kMetrics) {
    const char* key = key_in_file(metric, [&](const char* k) { return frames.contains(k); });
    if (key == nullptr) continue;  // written before there was this metric
    const json& values = frames.at(key);
    for (std::size_t i = 0; i < set.frames.size(); ++i) {
      if (!values.at(i).is_null()) set.frames[i][metric] = values[i].get<double>();
    }
  }
  if (frames.contains("readings")) {
    for (const json& frame : frames.at("readings")) set.readings.push_back(reading_from(frame));
    if (set.readings.size() != set.frames.size()) {
      throw std::invalid_argument("a reading for each frame is wanted");
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

/// Raised whenever the same images would score otherwise. A metric more needs no other version: the
/// key of what was scored holds the metrics' names.
constexpr int metrics_version = 1;

/// What determines any record of the entry on the test sets.
json key_of_tests(const Experiment& experiment, const SolverEntry& entry) {
  json key = {{"schema", record_schema},
              {"metrics", metrics_version},
              {"label", entry.label},
              {"entry", entry.spec.text()},
              {"solver", Cache::fitted_solver_key(fit_recipe(experiment, entry)).dump()}};
  for (const DatasetSpec& test : experiment.tests) key["tests"].push_back(to_json(test));
  return key;
}

/// p50, p99 and maximum of every frame's time. A percentile is a time that was measured.
LatencySummary summarise_latency(const SortedValues& microseconds) {
  return {nearest_rank_quantile(microseconds, 0.5), nearest_rank_quantile(microseconds, 0.99),
          microseconds.largest()};
}

/// One test set in all rounds.
struct Rounds {
  std::vector<double> microseconds;
  std::vector<double> p50;
  std::vector<double> relative;
  std::vector<double> frames_per_s;
  std::vector<double> pipe;      ///< microseconds
  std::vector<double> contacts;  ///< microseconds
  int batch = 0;

  void add(const json& times, double calibration_us) {
    const auto some = times.at("latency_us").get<std::vector<double>>();
    p50.push_back(summarise_latency(some).p50);
    relative.push_back(
        relative_latency(p50.back(), *std::ranges::min_element(some), calibration_us));
    microseconds.insert(microseconds.end(), some.begin(), some.end());
    frames_per_s.push_back(times.at("frames_per_s").get<double>());
    batch = times.at("batch").get<int>();
    const auto add_if_any = [&](const char* name, std::vector<double>& to) {
      if (!times.contains(name)) return;
      const auto more = times.at(name).get<std::vector<double>>();
      to.insert(to.end(), more.begin(), more.end());
    };
    add_if_any("pipe_us", pipe);
    add_if_any("contacts_us", contacts);
  }
};

}  // namespace

json to_json(const FrameReading& reading) {
  json contacts = json::array();
  for (const ContactReading& contact : reading.contacts) {
    contacts.push_back({contact.place_mm.x(), contact.place_mm.y(), contact.strength, contact.peak,
                        contact.area_mm2});
  }
  return {{"contacts", std::move(contacts)},
          {"peak", value_or_null(reading.peak)},
          {"sum", value_or_null(reading.sum)},
          {"centroid_mm", place_or_null(reading.centroid_mm)},
          {"centroid25_mm", place_or_null(reading.centroid25_mm)},
          {"explained", value_or_null(reading.explained)}};
}

std::string accuracy_key(const Experiment& experiment, const SolverEntry& entry) {
  json key = key_of_tests(experiment, entry);
  key["figure"] = experiment.figure_scenes;
  for (const Metric metric : kMetrics) key["scored"].push_back(first_name_of(metric));
  if (experiment.right_sizing) key["validation"] = true;
  if (experiment.contacts != ContactSettings{}) key["contacts"] = to_json(experiment.contacts);
  if (experiment.keep_contacts) key["keep_contacts"] = true;
  if (experiment.keep_explained) key["keep_explained"] = true;
  return hash_of(key.dump());
}

AccuracyRecord accuracy_record_from_json(const json& record, const Experiment& experiment,
                                         const std::string& source) {
  AccuracyRecord out;
  for (const json& row : record.at("rows")) {
    const json& frames = record.at("frames").at(row.at("dataset").get<std::string>());
    out.sets.push_back(scored_set(row, frames, source));
  }
  if (experiment.right_sizing) {
    out.validation = std::move(out.sets.back());
    out.sets.pop_back();
  }
  out.figure_images = images_from(record.at("figure_images"), experiment.sensor.pixels());
  return out;
}

double relative_latency(double median_us, double fastest_us, double calibration_us) {
  constexpr double long_frame_us = 1000;
  return (fastest_us < long_frame_us ? median_us : fastest_us) / calibration_us;
}

std::string timing_key(const Experiment& experiment, const SolverEntry& entry) {
  const TimingSettings& timing = experiment.timing;
  json key = key_of_tests(experiment, entry);
  key["timing"] = {timing.frames, timing.warm_up, timing.batch, timing.rounds};
  key["to_contacts"] = true;
  return hash_of(key.dump());
}

TimingPlace timing_place_of(const json& round) {
  const json& place = round.at("place");
  return {place.at("cpu").get<std::string>(), place.at("node").get<std::string>(),
          place.at("busy_cores").get<double>()};
}

json to_json(const TimingPlace& place) {
  return {{"cpu", place.cpu}, {"node", place.node}, {"busy_cores", place.busy_cores}};
}

TimingRecord timing_record_from_json(const std::vector<json>& rounds) {
  std::map<std::string, Rounds> sets;
  std::vector<double> calibration;
  TimingRecord record;
  for (const json& round : rounds) {
    calibration.push_back(round.at("calibration_us").get<double>());
    for (const auto& [dataset, times] : round.at("timing").items()) {
      sets[dataset].add(times, calibration.back());
    }
    record.peak_rss_mb = std::max(record.peak_rss_mb, round.at("peak_rss_mb").get<double>());
  }
  for (const auto& [dataset, set] : sets) {
    MeasuredTimes times{summarise_latency(set.microseconds), median(set.frames_per_s), set.batch};
    times.latency_us.p50_of_rounds = set.p50;
    times.latency_us.relative_of_rounds = set.relative;
    if (!set.pipe.empty()) times.latency_us.pipe = median(set.pipe);
    if (!set.contacts.empty()) {
      const LatencySummary to_contacts = summarise_latency(set.contacts);
      times.latency_us.contacts_p50 = to_contacts.p50;
      times.latency_us.contacts_p99 = to_contacts.p99;
    }
    record.sets[dataset] = std::move(times);
  }
  record.calibration_us = median(calibration);
  record.place = timing_place_of(rounds.front());
  for (const json& round : rounds) {
    record.place.busy_cores = std::max(record.place.busy_cores, timing_place_of(round).busy_cores);
  }
  return record;
}

}  // namespace ertbench
