#include "bench/live/live_json.h"

#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>

namespace ertbench {
namespace {

using nlohmann::json;

template <typename Value>
json or_null(const std::optional<Value>& value) {
  return value ? json(*value) : json();
}

double rounded(double value, double step) { return std::round(value / step) * step; }

}  // namespace

const char* name_of(FrameStatus status) {
  switch (status) {
    case FrameStatus::ok:
      return "ok";
    case FrameStatus::not_converged:
      return "not converged";
    case FrameStatus::suspect:
      return "suspect";
    case FrameStatus::undefined:
      break;
  }
  return "undefined";
}

json reasons_json(std::uint8_t reasons) {
  constexpr std::pair<FrameReason, const char*> names[] = {{dead_electrode, "dead electrode"},
                                                           {noise, "noise"},
                                                           {out_of_range, "out of range"},
                                                           {unexplained, "unexplained"}};
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
