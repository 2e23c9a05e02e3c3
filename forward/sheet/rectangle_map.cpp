#include "forward/sheet/rectangle_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr int theta_terms = 4;

/// A theta function and its first derivative.
struct Theta {
  Complex value, slope;
};

}  // namespace

RectangleMap::RectangleMap(double half_width, double half_height)
    : turned_(half_width > half_height),
      scale_(pi / (2 * std::min(half_width, half_height))),
      lift_(pi / 2 * std::max(half_width, half_height) / std::min(half_width, half_height)),
      nome_(std::exp(-4 * lift_)) {
  double theta = 1;
  for (int n = 1; n <= theta_terms; ++n) theta += 2 * (n % 2 ? -1 : 1) * std::pow(nome_, n * n);
  squared_theta_ = theta * theta;
}

DiscPoint RectangleMap::operator()(Complex z) const {
  const Complex turn = turned_ ? Complex(0, 1) : Complex(1, 0);
  const Complex v = scale_ * turn * z + Complex(0, lift_);
  // cos and sin of n v by powers of e^(iv); q^(1/4) is common to theta_1 and theta_2.
  const Complex step = std::exp(Complex(0, 1) * v);
  const Complex back = 1.0 / step;
  Theta one{}, two{}, three{1, 0}, four{1, 0};
  Complex up = 1;
  Complex down = 1;
  for (int n = 0; n <= 2 * theta_terms; ++n, up *= step, down *= back) {
    if (n == 0) continue;
    const double power = std::pow(nome_, n * n / 4.0);
    const Complex cosine = power * (up + down);
    const Complex sine = power * (up - down) * Complex(0, -1);
    const double k = n;
    if (n % 2) {
      const double sign = n / 2 % 2 ? -1 : 1;
      one.value += sign * sine;
      one.slope += sign * k * cosine;
      two.value += cosine;
      two.slope -= k * sine;
    } else {
      const double sign = n / 2 % 2 ? -1 : 1;
      three.value += cosine;
      three.slope -= k * sine;
      four.value += sign * cosine;
      four.slope -= sign * k * sine;
    }
  }
  const Complex i(0, 1);
  const Complex below = one.value + i * four.value;
  const Complex slope_below = one.slope + i * four.slope;
  const Complex product = two.value * three.value;
  const Complex factor = 2.0 * i * squared_theta_ / (below * below);
  const Complex first = factor * product;
  const Complex second = factor * (two.slope * three.value + two.value * three.slope -
                                   2.0 * product * slope_below / below);
  const Complex inner = scale_ * turn;
  return {(one.value - i * four.value) / below, inner * first, inner * inner * second};
}

}  // namespace ertbench
