#include "bench/record/frame_reading_record.h"

#include <nlohmann/json.hpp>

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

std::vector<FrameReading> frame_readings_from_json(const json& list) {
  std::vector<FrameReading> out;
  for (const json& frame : list) out.push_back(reading_from(frame));
  return out;
}

}  // namespace ertbench
