#include "forward/border/corner_grading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

constexpr double wanted_order = 3;

double contrast(double first, double second) { return (first - second) / (first + second); }

/// The exponent at one end of an arc: place and direction into the sheet, seen on the unit disc.
double exponent_at(const Sheet& sheet, const std::vector<ContactArc>& arcs, const ContactArc& arc,
                   bool is_begin) {
  const BorderPoint end = arc.piece.at(is_begin ? arc.begin : arc.end);
  const double kappa = contrast(arc.left, arc.right);
  if (is_begin ? arc.begins_at_sheet : arc.ends_at_sheet) {
    const DiscPoint place = sheet.to_disc(end.z);
    const Complex inwards = (is_begin ? 1.0 : -1.0) * place.first * end.first;
    // From the arc to the sheet's border on its left.
    const double angle = std::clamp(std::arg(Complex(0, -1) * place.w / inwards), 0.0, pi);
    return is_begin ? corner_exponent(arc.left, arc.right, angle)
                    : corner_exponent(arc.right, arc.left, angle);
  }
  const auto is_here = [&](double parameter, const ContactArc& other) {
    return std::abs(other.piece.at(parameter).z - end.z) < 1e-7;
  };
  const ContactArc* neighbour = nullptr;
  Complex away;
  int ends = 0;
  for (const ContactArc& other : arcs) {
    if (other.closed) continue;
    for (const bool begins : {true, false}) {
      const double parameter = begins ? other.begin : other.end;
      if (!is_here(parameter, other)) continue;
      ++ends;
      if (&other == &arc && begins == is_begin) continue;
      neighbour = &other;
      away = (begins ? 1.0 : -1.0) * other.piece.at(parameter).first;
    }
  }
  // Three and more borders: the least that any angles make of the contrast.
  if (ends != 2 || !neighbour) return 1 - std::asin(std::abs(kappa)) / pi;
  const Complex own = (is_begin ? 1.0 : -1.0) * end.first;
  const double angle = std::abs(std::arg(away / own)) / 2;
  // Symmetric and antisymmetric about the bisector; which side is which does not matter to both.
  return std::min(corner_exponent(arc.left, arc.right, angle),
                  corner_exponent(arc.right, arc.left, angle));
}

}  // namespace

double corner_exponent(double first, double second, double angle) {
  // first tan(lambda a) + second tan(lambda (pi - a)) = 0, freed of its poles.
  const double kappa = contrast(first, second);
  const auto value = [&](double lambda) {
    return std::sin(lambda * pi) + kappa * std::sin(lambda * (2 * angle - pi));
  };
  double low = 0.5;
  double high = 1;
  if (value(high) >= 0) return high;
  while (high - low > 1e-3) {
    const double middle = (low + high) / 2;
    (value(middle) > 0 ? low : high) = middle;
  }
  return low;
}

void set_gradings(const Sheet& sheet, std::vector<ContactArc>& arcs) {
  for (ContactArc& arc : arcs) {
    if (arc.closed || !is_strong(arc.left / arc.right)) continue;
    const double exponent =
        std::min(exponent_at(sheet, arcs, arc, true), exponent_at(sheet, arcs, arc, false));
    arc.grading = wanted_order / exponent;
  }
}

}  // namespace ertbench
