#include "bench/plot/axis.h"

#include <cmath>
#include <utility>

#include "core/text.h"

namespace ertbench {
namespace {

std::vector<Tick> named(const std::vector<double>& values) {
  std::vector<Tick> ticks;
  for (const double value : values) ticks.push_back({value, number_text(value)});
  return ticks;
}

}  // namespace

double round_step(double span, int ticks) {
  const double power = std::pow(10.0, std::floor(std::log10(span / ticks)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= span / ticks * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

std::vector<double> even_ticks(const Span& span, int ticks) {
  std::vector<double> out;
  const double step = round_step(span.high - span.low, ticks);
  const double first = std::ceil(span.low / step - 1e-9);
  const double last = std::floor(span.high / step + 1e-9);
  // Spans so narrow that their ends are hardly told apart have no ticks between them.
  constexpr double most = 1e15;
  constexpr int most_ticks = 1000;
  if (!(std::abs(first) < most && last - first < most_ticks)) return out;
  const int count = static_cast<int>(last - first) + 1;
  for (int k = 0; k < count; ++k) {
    const double i = first + k;
    out.push_back(i == 0 ? 0 : i * step);  // never minus zero
  }
  return out;
}

std::vector<double> log_ticks(const Span& span) {
  const double decades = std::log10(span.high / span.low);
  if (decades < 0.7) return even_ticks(span, 6);
  std::vector<double> ticks;
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

std::vector<Tick> time_ticks() {
  return {{0.1, "0.1 µs"}, {1, "1 µs"},     {10, "10 µs"}, {100, "100 µs"}, {1e3, "1 ms"},
          {1e4, "10 ms"},  {1e5, "100 ms"}, {1e6, "1 s"},  {1e7, "10 s"},   {1e8, "100 s"}};
}

std::vector<Tick> rate_ticks() {
  return {{0.1, "0.1"},  {1, "1"},       {10, "10"},   {100, "100"}, {1e3, "1 k"},
          {1e4, "10 k"}, {1e5, "100 k"}, {1e6, "1 M"}, {1e7, "10 M"}};
}

Axis Axis::even(const Span& span, std::string title) {
  return {span.low, span.high, false, named(even_ticks(span, 8)), std::move(title)};
}

Axis Axis::logarithms(const Span& span, std::string title) {
  return {span.low, span.high, true, named(log_ticks(span)), std::move(title)};
}

double Axis::share(double value) const {
  if (logarithmic) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

void Axis::cap() {
  constexpr double room = 0.05;  // of the axis, between two ticks
  while (!ticks.empty() && share(ticks.back().value) > 1 - room) ticks.pop_back();
  ticks.push_back({high, "≥ " + number_text(high)});
}

}  // namespace ertbench
