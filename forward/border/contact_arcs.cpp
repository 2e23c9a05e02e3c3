#include "forward/border/contact_arcs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// The probe of what lies beside a border goes this far.
constexpr double tolerance = BorderPiece::tolerance;

Eigen::Vector2d vector(Complex z) { return {z.real(), z.imag()}; }

std::vector<BorderPiece> border_of(const Contact& contact) {
  if (contact.shape == Shape::polygon) return polygon_border(contact.vertices);
  const Eigen::Vector2d u =
      contact.half_size.x() * Eigen::Vector2d(std::cos(contact.angle), std::sin(contact.angle));
  const Eigen::Vector2d v =
      contact.half_size.y() * Eigen::Vector2d(-std::sin(contact.angle), std::cos(contact.angle));
  const Eigen::Vector2d& c = contact.centre;
  if (contact.shape == Shape::rectangle)
    return polygon_border({c - u - v, c + u - v, c + u + v, c - u + v});
  return {BorderPiece::ellipse(c, u, v)};
}

}  // namespace

int contact_at(const Scene& scene, Complex point) {
  int lowest = -1;
  for (std::size_t k = 0; k < scene.contacts.size(); ++k) {
    if (!scene.contacts[k].contains(vector(point))) continue;
    if (lowest < 0 || scene.contacts[k].conductivity_ratio <
                          scene.contacts[static_cast<std::size_t>(lowest)].conductivity_ratio) {
      lowest = static_cast<int>(k);
    }
  }
  return lowest;
}

double ratio_at(const Scene& scene, Complex point) {
  const int contact = contact_at(scene, point);
  return contact < 0 ? 1 : scene.contacts[static_cast<std::size_t>(contact)].conductivity_ratio;
}

bool is_strong(double ratio) { return ratio < 0.1 || ratio > 10; }

bool are_joined(const ContactArc& a, const ContactArc& b) {
  if (a.closed || b.closed) return false;
  for (const double s : {a.begin, a.end}) {
    for (const double t : {b.begin, b.end}) {
      if (std::abs(a.piece.at(s).z - b.piece.at(t).z) < 1e-7) return true;
    }
  }
  return false;
}

std::vector<ContactArc> contact_arcs(const Scene& scene, const Sheet& sheet) {
  std::vector<std::vector<BorderPiece>> borders;
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const Contact& contact : scene.contacts) {
    borders.push_back(border_of(contact));
    boxes.push_back(contact.bounds());
  }
  const auto in_sheet = [&](Complex z, double margin) { return sheet.depth(vector(z)) > margin; };
  std::vector<ContactArc> arcs;
  std::vector<double> cuts;
  for (std::size_t k = 0; k < borders.size(); ++k) {
    const bool sticks_out = !sheet.encloses(boxes[k], tolerance);
    for (const BorderPiece& piece : borders[k]) {
      cuts.clear();
      const auto cut_at = [&](const std::vector<BorderPiece>& others) {
        for (const BorderPiece& other : others) {
          const std::vector<double> found = piece.crossings(other);
          cuts.insert(cuts.end(), found.begin(), found.end());
        }
      };
      for (std::size_t other = 0; other < borders.size(); ++other) {
        if (other != k && boxes[other].intersects(boxes[k])) cut_at(borders[other]);
      }
      if (sticks_out) cut_at(sheet.border());
      std::sort(cuts.begin(), cuts.end());
      const bool closed = piece.is_ellipse() && cuts.empty();
      if (piece.is_ellipse() && !closed) {
        cuts.push_back(cuts.front() + 2 * pi);
      } else {
        cuts.insert(cuts.begin(), 0.0);
        cuts.push_back(piece.length());
      }
      for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
        ContactArc arc{.piece = piece, .begin = cuts[c], .end = cuts[c + 1], .closed = closed};
        const BorderPoint middle = piece.at((arc.begin + arc.end) / 2);
        if ((arc.end - arc.begin) * std::abs(middle.first) < tolerance) continue;
        if (!in_sheet(middle.z, tolerance)) continue;
        const Complex left = Complex(0, tolerance) * middle.first / std::abs(middle.first);
        arc.contact = static_cast<int>(k);
        arc.left_contact = contact_at(scene, middle.z + left);
        arc.right_contact = contact_at(scene, middle.z - left);
        arc.left = ratio_at(scene, middle.z + left);
        arc.right = ratio_at(scene, middle.z - left);
        if (arc.left == arc.right) continue;
        const bool is_there = std::any_of(
            borders.begin(), borders.begin() + static_cast<std::ptrdiff_t>(k), [&](const auto& b) {
              return std::any_of(b.begin(), b.end(), [&](const BorderPiece& earlier) {
                return earlier.passes_through(middle.z, tolerance);
              });
            });
        if (is_there) continue;
        arc.begins_at_sheet = !in_sheet(piece.at(arc.begin).z, 2 * tolerance);
        arc.ends_at_sheet = !in_sheet(piece.at(arc.end).z, 2 * tolerance);
        arcs.push_back(arc);
      }
    }
  }
  return arcs;
}

}  // namespace ertbench
