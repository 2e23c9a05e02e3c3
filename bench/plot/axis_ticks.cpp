#include "bench/plot/axis_ticks.h"

#include <cmath>

#include "core/text.h"

namespace ertbench {
namespace {

/// The smallest of 1, 2 or 5 times a power of ten that divides `span` into at most `ticks` steps.
double step_for(double span, int ticks) {
  const double power = std::pow(10.0, std::floor(std::log10(span / ticks)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= span / ticks * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace

std::vector<double> log_ticks(const Span& span) {
  std::vector<double> ticks;
  const double decades = std::log10(span.high / span.low);
  if (decades < 0.7) {
    const double step = step_for(span.high - span.low, 6);
    for (double i = std::ceil(span.low / step); i * step <= span.high; ++i)
      ticks.push_back(i * step);
    return ticks;
  }
  const int every = std::max(1, static_cast<int>(std::ceil(decades / 8)));
  const int first = static_cast<int>(std::floor(std::log10(span.low)));
  for (int power = first; std::pow(10.0, power) <= span.high; ++power) {
    if (power % every != 0) continue;
    for (const double digit : decades > 3 ? std::vector{1.0} : std::vector{1.0, 2.0, 5.0}) {
      const double value = digit * std::pow(10.0, power);
      if (value >= span.low && value <= span.high) ticks.push_back(value);
    }
  }
  return ticks;
}

std::string tick_list(const std::vector<double>& ticks) {
  std::string out;
  for (const double value : ticks) {
    const std::string number = number_text(value);
    out += (out.empty() ? "'" : ", '") + number + "' " + number;
  }
  return out;
}

}  // namespace ertbench
