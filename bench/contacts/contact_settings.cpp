#include "bench/contacts/contact_settings.h"

#include <nlohmann/json.hpp>

namespace ertbench {
namespace {

nlohmann::json or_auto(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json("auto");
}

}  // namespace

ContactRule ContactSettings::rule() const {
  ContactRule rule;
  rule.threshold = threshold.value_or(rule.threshold);
  rule.floor = floor.value_or(rule.floor);
  rule.saddle = saddle;
  return rule;
}

ContactDistances ContactSettings::distances(const Sensor& sensor) const {
  const double side = sensor.sheet->size_mm().maxCoeff();
  return {match_mm.value_or(side / 10), ospa_mm.value_or(side / 4)};
}

nlohmann::json to_json(const ContactSettings& settings) {
  nlohmann::json json = {{"threshold", or_auto(settings.threshold)},
                         {"floor", or_auto(settings.floor)},
                         {"saddle", settings.saddle},
                         {"match_mm", or_auto(settings.match_mm)},
                         {"ospa_mm", or_auto(settings.ospa_mm)}};
  if (!settings.chosen_on.empty()) json["chosen_on"] = settings.chosen_on;
  return json;
}

}  // namespace ertbench
