#include "forward/sheet/square_map.h"

#include <numbers>

namespace ertbench {
namespace {

constexpr double lemniscate_constant = 2.62205755429211981;
/// Powers of t^4; in the corners each term is a quarter of the one before.
constexpr int terms = 27;
const std::complex<double> turn =
    lemniscate_constant / 4 * std::complex<double>(1, -1);  // varpi / (2 sqrt 2) e^(-i pi / 4)

}  // namespace

SquareMap::SquareMap() : series_(terms, 0.0) {
  // sl'' = -2 sl^3, coefficient by coefficient.
  series_[0] = 1;
  std::vector<double> square(terms, 0.0);
  for (std::size_t k = 1; k < terms; ++k) {
    for (std::size_t i = 0; i < k; ++i) square[k - 1] += series_[i] * series_[k - 1 - i];
    double cube = 0;
    for (std::size_t i = 0; i < k; ++i) cube += series_[i] * square[k - 1 - i];
    const auto power = static_cast<double>(4 * k);
    series_[k] = -2 * cube / (power * (power + 1));
  }
}

DiscPoint SquareMap::operator()(std::complex<double> z) const {
  const std::complex<double> t = turn * z;
  const double re = t.real() * t.real() - t.imag() * t.imag();
  const double im = 2 * t.real() * t.imag();
  const double x = re * re - im * im;  // t^4 = x + i y
  const double y = 2 * re * im;
  double a = 0;
  double b = 0;
  for (std::size_t k = terms; k-- > 0;) {
    const double next = a * x - b * y + series_[k];
    b = a * y + b * x;
    a = next;
  }
  const std::complex<double> w = t * std::complex<double>(a, b);
  const std::complex<double> square = w * w;
  // |w| <= 1, so 1 - w^4 stays in the right half plane and the principal root is the right one.
  const std::complex<double> slope = std::sqrt(1.0 - square * square);
  return {w, turn * slope, -2.0 * turn * turn * square * w};
}

}  // namespace ertbench
