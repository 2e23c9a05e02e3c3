#include "forward/sheet/sheet_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

constexpr double lemniscate_constant = 2.62205755429211981;
/// Powers of t^4; in the corners each term is a quarter of the one before.
constexpr int terms = 27;
const std::complex<double> turn =
    lemniscate_constant / 4 * std::complex<double>(1, -1);  // varpi / (2 sqrt 2) e^(-i pi / 4)

using Complex = std::complex<double>;

constexpr int theta_terms = 4;

/// A theta function and its first derivative.
struct Theta {
  Complex value, slope;
};

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

SquareSheet::SquareSheet(double side_mm)
    : Sheet(Eigen::AlignedBox2d(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), side_mm / 2),
      border_(polygon_border({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}})) {}

double SquareSheet::radius() const { return std::numbers::sqrt2; }

double SquareSheet::depth(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d beyond = point.cwiseAbs().array() - 1;
  if (beyond.maxCoeff() <= 0) return -beyond.maxCoeff();
  return -beyond.cwiseMax(0).norm();
}

Eigen::Vector2d SquareSheet::border_point(double along) const {
  const int side = (static_cast<int>(std::floor(along / 2)) % 4 + 4) % 4;
  const double t = along - 2 * std::floor(along / 2) - 1;
  switch (side) {
    case 0:
      return {t, 1};
    case 1:
      return {1, -t};
    case 2:
      return {-t, -1};
    default:
      return {-1, t};
  }
}

std::vector<Eigen::Matrix2d> SquareSheet::symmetries() const {
  std::vector<Eigen::Matrix2d> out;
  const Eigen::Matrix2d quarter{{0, -1}, {1, 0}};
  const Eigen::Matrix2d mirror{{-1, 0}, {0, 1}};
  for (const bool reflected : {false, true}) {
    Eigen::Matrix2d turn = reflected ? mirror : Eigen::Matrix2d::Identity();
    for (int rotation = 0; rotation < 4; ++rotation, turn = quarter * turn) out.push_back(turn);
  }
  return out;
}

const std::shared_ptr<const Sheet>& square_sheet() {
  static const std::shared_ptr<const Sheet> sheet = std::make_shared<const SquareSheet>(200);
  return sheet;
}

RectangleSheet::RectangleSheet(const Vector2d& sides_mm)
    : RectangleSheet(sides_mm / sides_mm.maxCoeff(), sides_mm.maxCoeff() / 2) {}

RectangleSheet::RectangleSheet(const Vector2d& half, double unit_mm)
    : Sheet(Eigen::AlignedBox2d(Vector2d(-half), half), unit_mm),
      half_(half),
      map_(half.x(), half.y()),
      border_(polygon_border({{-half.x(), -half.y()},
                              {half.x(), -half.y()},
                              {half.x(), half.y()},
                              {-half.x(), half.y()}})) {}

std::string RectangleSheet::extent() const {
  const auto interval = [](double half) {
    return "[-" + number_text(half) + ", " + number_text(half) + "]";
  };
  return interval(half_.x()) + " x " + interval(half_.y());
}

double RectangleSheet::depth(const Vector2d& point) const {
  const Vector2d beyond = point.cwiseAbs() - half_;
  if (beyond.maxCoeff() <= 0) return -beyond.maxCoeff();
  return -beyond.cwiseMax(0).norm();
}

Vector2d RectangleSheet::border_point(double along) const {
  const double width = 2 * half_.x();
  const double height = 2 * half_.y();
  double t = along - border_length() * std::floor(along / border_length());
  if (t < width) return {t - half_.x(), half_.y()};
  t -= width;
  if (t < height) return {half_.x(), half_.y() - t};
  t -= height;
  if (t < width) return {half_.x() - t, -half_.y()};
  return {-half_.x(), t - width - half_.y()};
}

std::vector<Eigen::Matrix2d> RectangleSheet::symmetries() const {
  std::vector<Eigen::Matrix2d> out;
  for (const double y : {1.0, -1.0}) {
    for (const double x : {1.0, -1.0}) {
      out.emplace_back(Eigen::Vector2d(x, y).asDiagonal());
    }
  }
  return out;
}

DiscSheet::DiscSheet(double diameter_mm)
    : Sheet(Eigen::AlignedBox2d(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), diameter_mm / 2),
      border_{BorderPiece::ellipse({0, 0}, {1, 0}, {0, 1})} {}

double DiscSheet::area() const { return std::numbers::pi; }

double DiscSheet::border_length() const { return 2 * std::numbers::pi; }

Eigen::Vector2d DiscSheet::border_point(double along) const {
  return {std::sin(along), std::cos(along)};
}

double DiscSheet::area_within(const Eigen::AlignedBox2d& box) const {
  Contact disc;
  disc.shape = Shape::disc;
  disc.half_size = {1, 1};
  return box.volume() * covered_fraction(disc, box);
}

std::vector<Eigen::Matrix2d> DiscSheet::symmetries() const { return square_sheet()->symmetries(); }

}  // namespace ertbench
