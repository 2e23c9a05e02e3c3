#include "core/moments.h"

#include <cmath>
#include <stdexcept>

namespace ertbench {

double mean(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("a mean of no values was asked for");
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) sum += value / count;
  return sum;
}

double sample_deviation(std::span<const double> values) {
  if (values.size() < 2) {
    throw std::invalid_argument("a standard deviation of fewer than two values was asked for");
  }
  const double middle = mean(values);
  double squares = 0;
  for (const double value : values) squares += (value - middle) * (value - middle);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

}  // namespace ertbench
