#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

namespace ertbench {

/// From the least value to the largest; empty before the first.
struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return low > high; }
};

/// The smallest of 1, 2 or 5 times a power of ten that divides `span` into at most `ticks` steps.
double round_step(double span, int ticks);

/// Multiples of a round step within the span, at most about `ticks`; none where the span is so
/// narrow beside its place that they are no different numbers.
std::vector<double> even_ticks(const Span& span, int ticks);

/// Values to stand at a logarithmic axis: in even steps over a narrow range, 1, 2, 5, 10, ... over
/// a few decades, powers of ten over many. The span must be positive.
std::vector<double> log_ticks(const Span& span);

/// A value at an axis and what is written there; may be empty for a line of the grid alone.
struct Tick {
  double value = 0;
  std::string text;
};

/// Ticks of a logarithmic axis in µs, one each decade: "10 µs", "1 ms".
std::vector<Tick> time_ticks();
/// The same for frames per second: "100", "1 k".
std::vector<Tick> rate_ticks();

/// The scale along one side of a panel or of a colour bar.
struct Axis {
  double low = 0;
  double high = 1;
  bool logarithmic = false;
  std::vector<Tick> ticks = {};
  std::string title = {};
  bool slanted = false;  ///< the ticks' texts stand at 45 degrees
  bool grid = true;      ///< a light line at each tick

  /// With even ticks.
  static Axis even(const Span& span, std::string title = {});
  /// With logarithmic ticks; the span must be positive.
  static Axis logarithms(const Span& span, std::string title = {});

  /// Where a value lies: 0 at `low` to 1 at `high`.
  double share(double value) const;
  double capped(double value) const { return std::clamp(value, low, high); }
  /// Says at the upper end that what lies above is drawn there: "≥ 10".
  void cap();
};

}  // namespace ertbench
