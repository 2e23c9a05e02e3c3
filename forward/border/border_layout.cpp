#include "forward/border/border_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace ertbench {
namespace {

using std::numbers::pi;

using Complex = std::complex<double>;

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

constexpr double wanted_order = 3;

double contrast(double first, double second) { return (first - second) / (first + second); }

/// Exponent at one end of an arc; position and inward direction on the unit disc.
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
  // Three or more borders: the least exponent over all angles at this contrast.
  if (ends != 2 || !neighbour) return 1 - std::asin(std::abs(kappa)) / pi;
  const Complex own = (is_begin ? 1.0 : -1.0) * end.first;
  const double angle = std::abs(std::arg(away / own)) / 2;
  // Symmetric and antisymmetric about the bisector; both are the same for either order of the
  // sides.
  return std::min(corner_exponent(arc.left, arc.right, angle),
                  corner_exponent(arc.right, arc.left, angle));
}

constexpr int least_open = 6;
constexpr int most_on_arc = 240;
/// Largest distance between points over the distance to their nearest neighbour.
constexpr double largest_spacing = 1.5;
/// An arc that would need more points than this is cut where it is most demanding.
constexpr int most_before_cut = 36;
constexpr int passes = 8;

/// The far side of an ellipse is two minor semi-axes away.
int least(const ContactArc& arc) {
  const int around =
      std::max(9, static_cast<int>(std::min<double>(most_on_arc, 2.1 * arc.piece.elongation())));
  if (arc.closed) return around;
  const double share = (arc.end - arc.begin) / arc.piece.length();
  return std::max(least_open, static_cast<int>(around * share));
}

/// Largest spacing on each arc, relative to the allowed one, and the point where it occurs.
struct Demand {
  double spacing = 0;
  int point = 0;
};

std::vector<Demand> demands(const std::vector<ContactArc>& arcs, const BorderPoints& points,
                            const Eigen::Array2Xd& electrodes) {
  // Neighbours at a corner or a junction come arbitrarily close, which the grading handles: there
  // only the middle halves of the arcs count.
  const auto is_middle = [&](std::size_t arc, Eigen::Index i) {
    const double place = (static_cast<double>(i) - points.first[arc] + 0.5) /
                         (points.first[arc + 1] - points.first[arc]);
    return std::abs(place - 0.5) < 0.25;
  };
  std::vector<Demand> out(arcs.size());
  for (std::size_t a = 0; a < arcs.size(); ++a) {
    std::vector<char> joined(arcs.size(), 0);
    for (std::size_t b = 0; b < arcs.size(); ++b) joined[b] = are_joined(arcs[a], arcs[b]);
    const bool touches_sheet = arcs[a].begins_at_sheet || arcs[a].ends_at_sheet;
    for (Eigen::Index i = points.first[a]; i < points.first[a + 1]; ++i) {
      const bool middle = is_middle(a, i);
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t b = 0; b < arcs.size(); ++b) {
        if (b == a || (joined[b] && !middle)) continue;
        for (Eigen::Index j = points.first[b]; j < points.first[b + 1]; ++j) {
          if (joined[b] && !is_middle(b, j)) continue;
          const double dx = points.x[i] - points.x[j];
          const double dy = points.y[i] - points.y[j];
          nearest = std::min(nearest, dx * dx + dy * dy);
        }
      }
      const double square =
          ((electrodes.row(0) - points.x[i]).square() + (electrodes.row(1) - points.y[i]).square())
              .minCoeff();
      nearest = std::sqrt(std::min(nearest, square));
      if (middle || !touches_sheet) nearest = std::min(nearest, points.depth[i]);
      const double spacing = points.weight[i] / (largest_spacing * nearest);
      if (spacing > out[a].spacing) out[a] = {spacing, static_cast<int>(i)};
    }
  }
  return out;
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

double corner_exponent(double first, double second, double angle) {
  // first tan(lambda a) + second tan(lambda (pi - a)) = 0, multiplied by its denominators.
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

Graded graded_parameter(const ContactArc& arc, int index, int count) {
  const double span = arc.end - arc.begin;
  if (arc.closed) return {arc.begin + span * index / count, span};
  const double s = (index + 0.5) / count;
  // The first point stays 1e-12 of the arc away from its end, so that rounding does not matter.
  const double p = std::max(3.0, std::min(arc.grading, 27.6 / std::log(2.0 * count)));
  const bool is_cubic = p == 3;  // the common case, in which pow would be slow
  const double up = is_cubic ? s * s * s : std::pow(s, p);
  const double down = is_cubic ? (1 - s) * (1 - s) * (1 - s) : std::pow(1 - s, p);
  const double sum = up + down;
  const double slope = p * (up / s) * (down / (1 - s)) / (sum * sum);
  return {arc.begin + span * up / sum, span * slope};
}

BorderPoints border_points(const Sheet& sheet, const std::vector<ContactArc>& arcs,
                           const std::vector<int>& counts) {
  BorderPoints points;
  points.first.assign(1, 0);
  for (const int count : counts) points.first.push_back(points.first.back() + count);
  const Eigen::Index total = points.first.back();
  for (Eigen::ArrayXd* array : {&points.x, &points.y, &points.normal_x, &points.normal_y,
                                &points.curvature, &points.weight, &points.depth}) {
    array->resize(total);
  }
  points.arc.resize(static_cast<std::size_t>(total));
  for (std::size_t a = 0; a < arcs.size(); ++a) {
    for (int k = 0; k < counts[a]; ++k) {
      const Graded graded = graded_parameter(arcs[a], k, counts[a]);
      const BorderPoint border = arcs[a].piece.at(graded.parameter);
      const DiscPoint value = sheet.to_disc(border.z);
      const std::complex<double> tangent = value.first * border.first;
      const std::complex<double> bend =
          value.second * border.first * border.first + value.first * border.second;
      const double speed = std::abs(tangent);
      const Eigen::Index i = points.first[a] + k;
      points.x[i] = value.w.real();
      points.y[i] = value.w.imag();
      points.normal_x[i] = tangent.imag() / speed;
      points.normal_y[i] = -tangent.real() / speed;
      points.curvature[i] = (std::conj(tangent) * bend).imag() / (speed * speed * speed);
      points.weight[i] = speed * graded.speed / counts[a];
      points.depth[i] = 1 - std::norm(value.w);
      points.arc[static_cast<std::size_t>(i)] = static_cast<int>(a);
    }
  }
  return points;
}

BorderLayout border_layout(const Sheet& sheet, const Eigen::Array2Xd& electrodes,
                           const Scene& scene, BorderCuts cuts) {
  BorderLayout layout{contact_arcs(scene, sheet), {}};
  set_gradings(sheet, layout.arcs);
  for (const ContactArc& arc : layout.arcs) layout.counts.push_back(least(arc));
  for (int pass = 0; pass < passes; ++pass) {
    const BorderPoints points = border_points(sheet, layout.arcs, layout.counts);
    const std::vector<Demand> wanted = demands(layout.arcs, points, electrodes);
    BorderLayout next;
    bool changed = false;
    for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
      const ContactArc& arc = layout.arcs[a];
      const int count = layout.counts[a];
      const int more = std::min(
          most_on_arc, static_cast<int>(std::ceil(count * std::min(wanted[a].spacing, 1e3))));
      if (more <= count) {
        next.arcs.push_back(arc);
        next.counts.push_back(count);
        continue;
      }
      changed = true;
      const double where =
          graded_parameter(arc, wanted[a].point - points.first[a], count).parameter;
      const double edge = 0.05 * (arc.end - arc.begin);  // nearer to an end the grading suffices
      if (cuts == BorderCuts::none || more <= most_before_cut ||
          (!arc.closed && (where < arc.begin + edge || where > arc.end - edge))) {
        next.arcs.push_back(arc);
        next.counts.push_back(more);
      } else if (arc.closed) {
        next.arcs.push_back(arc);
        next.arcs.back().begin = where;
        next.arcs.back().end = where + arc.piece.length();
        next.arcs.back().closed = false;
        next.counts.push_back(least(next.arcs.back()));
      } else {
        for (const bool first : {true, false}) {
          next.arcs.push_back(arc);
          ContactArc& part = next.arcs.back();
          (first ? part.end : part.begin) = where;
          (first ? part.ends_at_sheet : part.begins_at_sheet) = false;
          next.counts.push_back(least(part));
        }
      }
    }
    layout = std::move(next);
    if (!changed) break;
  }
  return layout;
}

}  // namespace ertbench
