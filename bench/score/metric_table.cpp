#include "bench/score/metric_table.h"

#include <cmath>
#include <stdexcept>

#include "core/text.h"

namespace ertbench {
namespace {

const char* unit_of(Quantity quantity) {
  switch (quantity) {
    case Quantity::ratio:
      return "";
    case Quantity::percent:
      return "%";
    case Quantity::length:
      return "sheet 2 × 2";
    case Quantity::millimetres:
      return "mm";
    case Quantity::number:
      return "";
  }
  return "";
}

}  // namespace

Metric metric_from_name(const std::string& name) {
  for (const MetricEntry& entry : kMetricTable) {
    if (name == entry.name) return entry.metric;
  }
  throw std::invalid_argument("no metric is called \"" + name + "\"");
}

double size_of(Quantity quantity) {
  return quantity == Quantity::percent || quantity == Quantity::millimetres ? 100 : 1;
}

std::string axis_title(Metric metric) {
  const std::string unit = unit_of(entry_of(metric).quantity);
  const std::string title = entry_of(metric).title;
  return unit.empty() ? title : title + " (" + unit + ")";
}

std::optional<double> ideal_of(Metric metric, const std::optional<double>& of_truth) {
  const Ideal& ideal = entry_of(metric).ideal;
  return ideal.of_truth ? of_truth : std::optional(ideal.value);
}

std::string ideal_text(Metric metric, double ideal) {
  if (entry_of(metric).ideal.of_truth) return "truth " + fixed(ideal, decimals_of(metric));
  return "ideal " + fixed(ideal, 0);
}

double distance_from_ideal(Metric metric, double value, const std::optional<double>& of_truth) {
  const MetricEntry& entry = entry_of(metric);
  const double ideal = ideal_of(metric, of_truth).value_or(entry.ideal.value);
  switch (entry.better) {
    case Better::smaller:
      return value - ideal;
    case Better::larger:
      return ideal - value;
    case Better::nearer:
      return std::abs(value - ideal);
  }
  return 0;
}

std::string distance_title(Metric metric) {
  const MetricEntry& entry = entry_of(metric);
  const std::string ideal = entry.ideal.of_truth ? "truth" : fixed(entry.ideal.value, 0);
  switch (entry.better) {
    case Better::smaller:
      return axis_title(metric);
    case Better::larger:
      return ideal + " − " + entry.title;
    case Better::nearer:
      return std::string("|") + entry.title + " − " + ideal + "|";
  }
  return "";
}

}  // namespace ertbench
