#include "forward/sheet/rasterise.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "forward/sheet/cross.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

/// A contact with precomputed geometry. A disc, ellipse or rectangle is the image of the unit disc
/// or of [-1, 1]^2 under an affine map; `to_unit` is the inverse map.
struct Outline {
  explicit Outline(const Contact& c) : contact(&c) {
    if (c.shape == Shape::polygon) return;
    const Eigen::Rotation2Dd turn(-c.angle);
    to_unit = c.half_size.cwiseInverse().asDiagonal() * turn.toRotationMatrix();
    unit_area = c.half_size.prod();
  }

  Vector2d unit(const Vector2d& point) const { return to_unit * (point - contact->centre); }

  const Contact* contact;
  Eigen::Matrix2d to_unit = Eigen::Matrix2d::Identity();
  double unit_area = 1;  ///< area of the image of the unit square
};

/// Signed area of the part of the triangle (0, a, b) that lies in the unit disc.
double triangle_in_disc(const Vector2d& a, const Vector2d& b) {
  const auto sector = [](const Vector2d& p, const Vector2d& q) {
    return 0.5 * std::atan2(cross(p, q), p.dot(q));
  };
  const Vector2d d = b - a;
  const double along = d.squaredNorm();
  const double half = a.dot(d);
  const double discriminant = half * half - along * (a.squaredNorm() - 1);
  if (discriminant <= 0) return sector(a, b);
  const double enter = (-half - std::sqrt(discriminant)) / along;
  const double leave = (-half + std::sqrt(discriminant)) / along;
  if (enter >= 1 || leave <= 0) return sector(a, b);
  double area = 0;
  Vector2d from = a;
  Vector2d to = b;
  if (enter > 0) {
    from = a + enter * d;
    area += sector(a, from);
  }
  if (leave < 1) {
    to = a + leave * d;
    area += sector(to, b);
  }
  return area + 0.5 * cross(from, to);
}

/// Clips a polygon to the half plane `normal . x <= offset` (Sutherland-Hodgman). A non-convex
/// polygon leaves edges that run to and fro along the line; they add no area.
void clip(std::vector<Vector2d>& polygon, const Vector2d& normal, double offset) {
  thread_local std::vector<Vector2d> kept;
  kept.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d& b = polygon[(i + 1) % polygon.size()];
    const double outside_a = normal.dot(a) - offset;
    const double outside_b = normal.dot(b) - offset;
    if (outside_a <= 0) kept.push_back(a);
    if ((outside_a < 0 && outside_b > 0) || (outside_a > 0 && outside_b < 0)) {
      kept.push_back(a + (b - a) * (outside_a / (outside_a - outside_b)));
    }
  }
  polygon.swap(kept);
}

double clipped_area(std::vector<Vector2d>& polygon, const Vector2d& low, const Vector2d& high) {
  for (int axis = 0; axis < 2 && !polygon.empty(); ++axis) {
    const Vector2d normal = Vector2d::Unit(axis);
    clip(polygon, normal, high[axis]);
    clip(polygon, -normal, -low[axis]);
  }
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  }
  return std::abs(twice) / 2;
}

/// True if no edge of the polygon comes within `distance` of the point.
bool far_from_border(const std::vector<Vector2d>& vertices, const Vector2d& point,
                     double distance) {
  for (std::size_t i = 0, j = vertices.size() - 1; i < vertices.size(); j = i++) {
    const Vector2d edge = vertices[i] - vertices[j];
    const Vector2d to_point = point - vertices[j];
    const double along =
        std::clamp(to_point.dot(edge) / std::max(edge.squaredNorm(), 1e-300), 0.0, 1.0);
    if ((to_point - along * edge).squaredNorm() <= distance * distance) return false;
  }
  return true;
}

/// Fraction of the pixel that the contact covers.
double coverage(const Outline& outline, const Vector2d& corner, const Vector2d& pixel) {
  const Contact& contact = *outline.contact;
  thread_local std::vector<Vector2d> polygon;
  const double pixel_area = pixel.prod();
  if (contact.shape == Shape::polygon) {
    const Vector2d centre = corner + pixel / 2;
    if (far_from_border(contact.vertices, centre, pixel.norm() / 2)) {
      return contact.contains(centre) ? 1 : 0;
    }
    polygon = contact.vertices;
    return std::min(1.0, clipped_area(polygon, corner, corner + pixel) / pixel_area);
  }

  const Vector2d middle = outline.unit(corner + pixel / 2);
  const Eigen::Matrix2d half = outline.to_unit * (pixel / 2).asDiagonal();
  const std::array<Vector2d, 4> corners = {
      middle - half.col(0) - half.col(1), middle + half.col(0) - half.col(1),
      middle + half.col(0) + half.col(1), middle - half.col(0) + half.col(1)};
  if (contact.shape == Shape::rectangle) {
    const Vector2d reach = half.cwiseAbs().rowwise().sum();
    if (((middle.cwiseAbs() + reach).array() <= 1).all()) return 1;
    if (((middle.cwiseAbs() - reach).array() >= 1).any()) return 0;
    polygon.assign(corners.begin(), corners.end());
    const double area = clipped_area(polygon, Vector2d(-1, -1), Vector2d(1, 1));
    return std::min(1.0, area * outline.unit_area / pixel_area);
  }
  double farthest = 0;
  for (const Vector2d& c : corners) farthest = std::max(farthest, c.squaredNorm());
  if (farthest <= 1) return 1;
  const double reach = std::sqrt(half.col(0).squaredNorm() + half.col(1).squaredNorm() +
                                 2 * std::abs(half.col(0).dot(half.col(1))));
  if (middle.norm() >= 1 + reach) return 0;
  double area = 0;
  for (std::size_t c = 0; c < 4; ++c) area += triangle_in_disc(corners[c], corners[(c + 1) % 4]);
  return std::clamp(area * outline.unit_area / pixel_area, 0.0, 1.0);
}

/// Appends the intervals of x in which the line at height y lies in the contact, as pairs.
void crossings(const Outline& outline, double y, std::vector<double>& out) {
  const Contact& contact = *outline.contact;
  const std::size_t first = out.size();
  if (contact.shape == Shape::polygon) {
    const auto& v = contact.vertices;
    for (std::size_t i = 0, j = v.size() - 1; i < v.size(); j = i++) {
      if ((v[i].y() > y) == (v[j].y() > y)) continue;
      out.push_back(v[i].x() + (v[j].x() - v[i].x()) * (y - v[i].y()) / (v[j].y() - v[i].y()));
    }
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(first), out.end());
    return;
  }
  const Vector2d start = outline.unit({0, y});
  const Vector2d step = outline.to_unit.col(0);
  double enter = -1e9;
  double leave = 1e9;
  if (contact.shape == Shape::rectangle) {
    for (int axis = 0; axis < 2; ++axis) {
      if (step[axis] == 0) {
        if (std::abs(start[axis]) > 1) return;
        continue;
      }
      const double a = (-1 - start[axis]) / step[axis];
      const double b = (1 - start[axis]) / step[axis];
      enter = std::max(enter, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
  } else {
    const double along = step.squaredNorm();
    const double half = start.dot(step);
    const double discriminant = half * half - along * (start.squaredNorm() - 1);
    if (discriminant <= 0) return;
    enter = (-half - std::sqrt(discriminant)) / along;
    leave = (-half + std::sqrt(discriminant)) / along;
  }
  if (enter < leave) out.insert(out.end(), {enter, leave});
}

/// Mean ratio over a pixel where borders of several contacts meet.
double mean_ratio(const std::vector<const Outline*>& outlines, double base, bool base_covered,
                  const Vector2d& corner, const Vector2d& pixel) {
  double sum = 0;
  std::vector<double> cuts;
  std::vector<std::size_t> start;
  std::vector<double> stops;
  for (int line = 0; line < overlap_lines; ++line) {
    const double y = corner.y() + pixel.y() * (line + 0.5) / overlap_lines;
    cuts.clear();
    start.assign(1, 0);
    for (const Outline* outline : outlines) {
      crossings(*outline, y, cuts);
      start.push_back(cuts.size());
    }
    stops = {corner.x(), corner.x() + pixel.x()};
    for (const double x : cuts) {
      if (x > corner.x() && x < corner.x() + pixel.x()) stops.push_back(x);
    }
    std::sort(stops.begin(), stops.end());
    for (std::size_t s = 0; s + 1 < stops.size(); ++s) {
      const double x = (stops[s] + stops[s + 1]) / 2;
      double lowest = base;
      bool covered = base_covered;
      for (std::size_t k = 0; k < outlines.size(); ++k) {
        for (std::size_t c = start[k]; c + 1 < start[k + 1]; c += 2) {
          if (x < cuts[c] || x > cuts[c + 1]) continue;
          const double ratio = outlines[k]->contact->conductivity_ratio;
          lowest = covered ? std::min(lowest, ratio) : ratio;
          covered = true;
        }
      }
      sum += lowest * (stops[s + 1] - stops[s]);
    }
  }
  return sum / (pixel.x() * overlap_lines);
}

/// One contact's share of one pixel; the shares of a pixel are a linked list.
struct Share {
  int pixel;
  int contact;
  double fraction;
  int next;
};

double ratio_of(const std::vector<Share>& shares, int head, const std::vector<Outline>& outlines,
                const Vector2d& corner, const Vector2d& pixel) {
  const auto ratio = [&](const Share& share) {
    return outlines[static_cast<std::size_t>(share.contact)].contact->conductivity_ratio;
  };
  // The lowest ratio among contacts that cover the whole pixel hides all higher ones.
  double base = 1;
  bool covered = false;
  for (int s = head; s >= 0; s = shares[static_cast<std::size_t>(s)].next) {
    const Share& share = shares[static_cast<std::size_t>(s)];
    if (share.fraction < 1) continue;
    base = covered ? std::min(base, ratio(share)) : ratio(share);
    covered = true;
  }
  std::vector<const Outline*> partial;
  double fraction = 0;
  for (int s = head; s >= 0; s = shares[static_cast<std::size_t>(s)].next) {
    const Share& share = shares[static_cast<std::size_t>(s)];
    if (share.fraction >= 1 || (covered && ratio(share) >= base)) continue;
    partial.push_back(&outlines[static_cast<std::size_t>(share.contact)]);
    fraction = share.fraction;
  }
  if (partial.empty()) return base;
  if (partial.size() == 1) {
    return base + fraction * (partial[0]->contact->conductivity_ratio - base);
  }
  return mean_ratio(partial, base, covered, corner, pixel);
}

}  // namespace

void rasterise(const Scene& scene, const PixelGrid& pixels, Rasterisation rule,
               Eigen::Ref<VectorXd> ratio) {
  if (scene.patches) return rasterise(*scene.patches, pixels, ratio);
  const Vector2d& side = pixels.pixel();
  ratio.setOnes();
  std::vector<Outline> outlines;
  for (const Contact& contact : scene.contacts) outlines.emplace_back(contact);
  std::vector<Share> shares;
  thread_local std::vector<int> heads;
  heads.assign(static_cast<std::size_t>(pixels.count()), -1);
  for (std::size_t k = 0; k < outlines.size(); ++k) {
    const Eigen::AlignedBox2d box = outlines[k].contact->bounds();
    const Eigen::Array2d last(pixels.columns() - 1, pixels.rows() - 1);
    const Eigen::Array2i low =
        pixels.place(box.min()).array().floor().max(0.0).min(last).cast<int>();
    const Eigen::Array2i high =
        pixels.place(box.max()).array().floor().max(0.0).min(last).cast<int>();
    for (int row = low.y(); row <= high.y(); ++row) {
      for (int column = low.x(); column <= high.x(); ++column) {
        const int pixel = column + pixels.columns() * row;
        if (!pixels.on_sheet(pixel)) continue;
        const Vector2d corner = pixels.corner(column, row);
        const double fraction = rule == Rasterisation::area
                                    ? coverage(outlines[k], corner, side)
                                    : double(outlines[k].contact->contains(corner + side / 2));
        if (fraction <= 0) continue;
        int& head = heads[static_cast<std::size_t>(pixel)];
        shares.push_back({pixel, static_cast<int>(k), fraction, head});
        head = static_cast<int>(shares.size()) - 1;
      }
    }
  }
  for (std::size_t s = 0; s < shares.size(); ++s) {
    const int pixel = shares[s].pixel;
    const int head = heads[static_cast<std::size_t>(pixel)];
    if (head != static_cast<int>(s)) continue;  // one visit for each pixel
    ratio[pixel] = ratio_of(shares, head, outlines, pixels.corner(pixel), side);
  }
}

double covered_fraction(const Contact& contact, const Eigen::AlignedBox2d& box) {
  return coverage(Outline(contact), box.min(), box.sizes());
}

const char* name_of(Rasterisation rule) { return rule == Rasterisation::area ? "area" : "centre"; }

}  // namespace ertbench
