#include "forward/touch/contact_law.h"

#include <cmath>

namespace ertbench {
namespace {

/// x / tanh x as a function of x^2, and its derivative by x^2; both smooth at 0.
struct Shunt {
  double value;
  double slope;

  explicit Shunt(double square) {
    if (square < 1e-4) {
      value = 1 + square / 3 - square * square / 45;
      slope = 1.0 / 3 - 2 * square / 45;
      return;
    }
    const double x = std::sqrt(square);
    const double t = std::tanh(x);
    value = x / t;
    slope = (1 / t - x * (1 - t * t) / (t * t)) / (2 * x);
  }
};

/// The pressure at which x = 1: x^2 = p / unit.
double unit_pressure(const RisingLaw& law) {
  // x / tanh x = ratio by x <- ratio tanh x, which contracts for every ratio > 1.
  double x = law.reference_ratio;
  for (int i = 0; i < 200; ++i) x = law.reference_ratio * std::tanh(x);
  return law.reference_pressure_kPa / (x * x);
}

}  // namespace

double conductivity_ratio(const ContactLaw& law, double kPa) {
  if (const auto* falling = std::get_if<FallingLaw>(&law)) {
    return 1 - falling->depth * kPa / (kPa + falling->half_pressure_kPa);
  }
  return Shunt(kPa / unit_pressure(std::get<RisingLaw>(law))).value;
}

double conductivity_ratio_slope(const ContactLaw& law, double kPa) {
  if (const auto* falling = std::get_if<FallingLaw>(&law)) {
    const double sum = kPa + falling->half_pressure_kPa;
    return -falling->depth * falling->half_pressure_kPa / (sum * sum);
  }
  const double unit = unit_pressure(std::get<RisingLaw>(law));
  return Shunt(kPa / unit).slope / unit;
}

}  // namespace ertbench
