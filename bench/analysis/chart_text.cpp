#include "bench/analysis/chart_text.h"

#include "core/text.h"

namespace ertbench {

std::string time_text(double microseconds) {
  if (microseconds < 999.5) return three_digits(microseconds) + " µs";
  if (microseconds < 999.5e3) return three_digits(microseconds / 1e3) + " ms";
  if (microseconds < 60e6) return three_digits(microseconds / 1e6) + " s";
  return three_digits(microseconds / 60e6) + " min";
}

std::string rate_text(double per_second) {
  if (per_second < 999.5) return three_digits(per_second);
  if (per_second < 999.5e3) return three_digits(per_second / 1e3) + " k";
  return three_digits(per_second / 1e6) + " M";
}

std::string description(const SpeedPoint& point, const SpeedAccuracy& chart) {
  std::string text = point.label;
  const auto add = [&](const std::string& line) { text += "\n" + line; };
  if (point.error) {
    std::string line = "median " + axis_title(chart.metric) + ": " + three_digits(*point.error);
    if (point.error_ci95) {
      line += " (95 %: " + three_digits(point.error_ci95->low) + " to " +
              three_digits(point.error_ci95->high) + ")";
    }
    add(line);
  }
  if (point.latency) {
    add("one frame: p50 " + time_text(point.latency->p50) + ", p99 " +
        time_text(point.latency->p99));
  }
  if (point.frames_per_s) {
    add(rate_text(*point.frames_per_s) + " frames/s, " + std::to_string(chart.batch) +
        " at a time");
  }
  if (point.fit_s) add("fit: " + time_text(1e6 * *point.fit_s));
  if (point.validation_error) add("validation error: " + three_digits(*point.validation_error));
  if (point.frontier) add("on the frontier");
  if (point.right_size) add("the smallest of its family that is good enough");
  if (!point.remark.empty()) add(point.remark);
  return text;
}

}  // namespace ertbench
