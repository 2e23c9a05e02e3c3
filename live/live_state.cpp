#include "live/live_state.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/json.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr double shown_every_s = 0.04;  ///< 25 states a second
constexpr double rates_over_s = 2;

/// Frames per second between the first and the last entry.
double rate_of(const std::vector<std::array<double, 3>>& history, std::size_t which) {
  if (history.size() < 2) return 0;
  const double span = history.back()[0] - history.front()[0];
  return span > 0 ? (history.back()[which] - history.front()[which]) / span : 0;
}

/// `value` rounded to three significant digits; 0 if it is not finite.
double shortened(double value) {
  if (value == 0 || !std::isfinite(value)) return 0;
  const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 2);
  return std::round(value / step) * step;
}

/// Corners of a rectangular sheet, or points along a curved border, [2, n] in domain units.
Eigen::Matrix2Xd outline_of(const Sheet& sheet) {
  if (sheet.fills_bounds()) {
    Eigen::Matrix2Xd corners(2, 4);
    const Eigen::Vector2d low = sheet.bounds().min();
    const Eigen::Vector2d high = sheet.bounds().max();
    corners << low.x(), high.x(), high.x(), low.x(), low.y(), low.y(), high.y(), high.y();
    return corners;
  }
  constexpr int points = 90;
  Eigen::Matrix2Xd border(2, points);
  for (int i = 0; i < points; ++i) {
    border.col(i) = sheet.border_point(sheet.border_length() * i / points);
  }
  return border;
}

/// [[x, y], ...] in mm from the sheet's centre; `places` [2, n] in domain units.
json places_mm(const Sensor& sensor, const Eigen::Matrix2Xd& places) {
  json out = json::array();
  const Eigen::Vector2d centre = sensor.sheet->bounds().center();
  for (Eigen::Index i = 0; i < places.cols(); ++i) {
    const Eigen::Vector2d place = sensor.sheet->unit_mm() * (places.col(i) - centre);
    out.push_back({shortened(place.x()), shortened(place.y())});
  }
  return out;
}

double rounded(double value, double step) { return std::round(value / step) * step; }

}  // namespace

std::uint64_t LiveCounts::all_damaged() const {
  std::uint64_t sum = 0;
  for (const std::uint64_t one : damaged) sum += one;
  return sum;
}

void LiveState::show() {
  shown_s_ = time_s_;
  ++version_;
  history_.push_back(
      {time_s_, static_cast<double>(counts_.came), static_cast<double>(counts_.answered)});
  const auto old = std::ranges::find_if(
      history_, [&](const auto& entry) { return entry[0] >= time_s_ - rates_over_s; });
  history_.erase(history_.begin(), old);
  changed_.notify_all();
}

void LiveState::update(const LiveCounts& counts, double time_s) {
  const std::lock_guard lock(mutex_);
  counts_ = counts;
  time_s_ = time_s;
  if (time_s >= shown_s_ + shown_every_s) show();
}

void LiveState::update(const LiveCounts& counts, double time_s, const ArrivedFrame& frame,
                       const LiveAnswer& answer, double latency_s) {
  const std::lock_guard lock(mutex_);
  counts_ = counts;
  time_s_ = time_s;
  latency_.add(latency_s);
  if (time_s < answer_s_ + shown_every_s) return;
  answer_s_ = time_s;
  answer_ = answer;
  frame_ = frame.number;
  latency_s_ = latency_s;
  any_answer_ = true;
  show();
}

void LiveState::set_silence(double silent_s) {
  const std::lock_guard lock(mutex_);
  silent_s_ = silent_s;
}

void LiveState::finish() {
  finished_ = true;
  const std::lock_guard lock(mutex_);
  ++version_;
  changed_.notify_all();
}

std::uint64_t LiveState::wait_for_newer(std::uint64_t version) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::seconds(1), [&] { return version_ > version; });
  return version_;
}

std::string LiveState::json() const {
  LiveCounts counts;
  LatencyHistogram latency;
  LiveAnswer answer;
  nlohmann::json out;
  {
    // The lock covers copies only, so that the solver does not wait while text is made.
    const std::lock_guard lock(mutex_);
    counts = counts_;
    latency = latency_;
    if (any_answer_) answer = answer_;
    out = {{"solver", heading_.solver},
           {"input", heading_.input},
           {"time_s", time_s_},
           {"silent_s", silent_s_},
           {"finished", finished_.load()},
           {"came_per_s", rate_of(history_, 1)},
           {"answered_per_s", rate_of(history_, 2)}};
    if (any_answer_) out.update({{"frame", frame_}, {"latency_us", 1e6 * latency_s_}});
  }
  const Sensor& sensor = heading_.sensor;
  const Eigen::Vector2d size = sensor.sheet->size_mm();
  out["size_mm"] = {size.x(), size.y()};
  out["image_size"] = {sensor.image_rows(), sensor.image_columns()};
  out["outline"] = places_mm(sensor, outline_of(*sensor.sheet));
  out["electrodes"] = places_mm(sensor, electrode_positions(sensor));
  out["counts"] = counts_json(counts);
  out["latency"] = latency_json(latency);
  out["histogram"] = histogram_json(latency);
  out["deadline_us"] =
      heading_.deadline_s > 0 ? nlohmann::json(1e6 * heading_.deadline_s) : nlohmann::json();
  if (answer.image.size() > 0) {
    out["answer"] = answer_json(answer, sensor);
    nlohmann::json image = nlohmann::json::array();
    if (answer.report.status != FrameStatus::undefined) {
      for (const double change : answer.image.row(0)) image.push_back(shortened(change));
    }
    out["image"] = std::move(image);
  }
  return json_text(out);
}

const char* name_of(FrameStatus status) {
  if (status == FrameStatus::ok) return "ok";
  if (status == FrameStatus::not_converged) return "not converged";
  return status == FrameStatus::suspect ? "suspect" : "undefined";
}

json reasons_json(std::uint8_t reasons) {
  constexpr std::pair<int, const char*> names[] = {
      {dead_electrode, "dead electrode"}, {noise, "noise"},
      {out_of_range, "out of range"},     {unexplained, "unexplained"},
      {turned_sign, "opposite sign"},     {wrong_level, "impossible level"},
      {wrong_reference, "reference"},     {impossible_change, "impossible change"}};
  json out = json::array();
  for (const auto& [reason, name] : names) {
    if ((reasons & reason) != 0) out.push_back(name);
  }
  return out;
}

json answer_json(const LiveAnswer& answer, const Sensor& sensor) {
  const Eigen::Vector2d centre_mm = sensor.sheet->unit_mm() * sensor.sheet->bounds().center();
  double strengths = 0;
  for (const ContactReading& one : answer.reading.contacts) strengths += one.strength;
  json contacts = json::array();
  for (const ContactReading& one : answer.reading.contacts) {
    const Eigen::Vector2d place = one.place_mm - centre_mm;
    json contact = {{"x_mm", rounded(place.x(), 1e-3)}, {"y_mm", rounded(place.y(), 1e-3)},
                    {"strength", one.strength},         {"peak", one.peak},
                    {"area_mm2", one.area_mm2},         {"force_N", nullptr}};
    if (answer.force_N && strengths > 0) {
      contact["force_N"] = *answer.force_N * one.strength / strengths;
    }
    contacts.push_back(std::move(contact));
  }
  json tracks = json::array();
  for (const TrackPoint& track : answer.tracks) {
    if (!track.confirmed) continue;
    tracks.push_back({{"id", track.id},
                      {"x_mm", rounded(track.place_mm.x(), 1e-3)},
                      {"y_mm", rounded(track.place_mm.y(), 1e-3)},
                      {"vx_mm_s", rounded(track.velocity_mm_s.x(), 1e-2)},
                      {"vy_mm_s", rounded(track.velocity_mm_s.y(), 1e-2)},
                      {"seen", track.seen}});
  }
  json dead = json::array();
  for (ElectrodeSet left = answer.report.dead; left != 0; left &= left - 1) {
    dead.push_back(std::countr_zero(left));
  }
  const auto signal =
      answer.reading.peak ? std::optional(std::abs(*answer.reading.peak)) : std::nullopt;
  return {{"status", name_of(answer.report.status)},
          {"reasons", reasons_json(answer.report.reasons)},
          {"dead_electrodes", std::move(dead)},
          {"contacts", std::move(contacts)},
          {"tracks", std::move(tracks)},
          {"force_N", or_null(answer.force_N)},
          {"signal", or_null(signal)},
          {"alarm", or_null(answer.alarm)}};
}

json counts_json(const LiveCounts& counts) {
  json damaged = json::object();
  for (const Damage damage : all_damages) {
    damaged[name_of(damage)] = counts.damaged[static_cast<std::size_t>(damage)];
  }
  return {{"came", counts.came},
          {"answered", counts.answered},
          {"dropped", counts.dropped},
          {"late", counts.late},
          {"damaged", std::move(damaged)}};
}

json histogram_json(const LatencyHistogram& latency) {
  constexpr int shown_classes_per_decade = 10;
  return {{"least_s", 1e-6},
          {"per_decade", shown_classes_per_decade},
          {"counts", latency.coarse(shown_classes_per_decade)}};
}

json latency_json(const LatencyHistogram& latency) {
  const auto us = [&](double share) {
    const std::optional<double> s = latency.quantile_s(share);
    return s ? json(1e6 * *s) : json();
  };
  return {{"p50", us(0.5)}, {"p99", us(0.99)}, {"max", us(1)}};
}

}  // namespace ertbench
