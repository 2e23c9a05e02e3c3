#include "forward/border/border_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ertbench {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

/// Limit of the gathering, so that the far side keeps enough points.
constexpr std::array gathering_strengths = {0.8, 0.64, 0.5, 0.4, 0.32};
/// Share of the least number of points that suffices on the far side.
constexpr double least_far_off = 0.5;

/// Connected arcs with the region's conductivity on one side.
struct Outline {
  std::vector<int> arcs;
  int sheet_ends = 0;
  double area = 0;  ///< of the region if it lies within, negative if it lies around
  /// Ends of the region's part of the sheet's border, counter-clockwise.
  double begin = 0, end = 0;
};

double angle_of(const Sheet& sheet, std::complex<double> point) {
  return std::arg(sheet.to_disc(point).w);
}

/// Counter-clockwise distance from one angle to another.
double turn(double from, double to) {
  const double angle = std::fmod(to - from, 2 * std::numbers::pi);
  return angle < 0 ? angle + 2 * std::numbers::pi : angle;
}

bool is_same(double a, double b) { return std::abs(a - b) < 1e-12 * std::abs(b); }

/// Outlines of all regions of conductivity `ratio`.
std::vector<Outline> outlines(const Sheet& sheet, const BorderLayout& layout,
                              const BorderPoints& points, double ratio) {
  std::vector<Outline> out;
  std::vector<char> is_taken(layout.arcs.size(), 0);
  const auto bounds = [&](std::size_t a) {
    return is_same(layout.arcs[a].left, ratio) || is_same(layout.arcs[a].right, ratio);
  };
  for (std::size_t start = 0; start < layout.arcs.size(); ++start) {
    if (is_taken[start] || !bounds(start)) continue;
    Outline outline;
    outline.arcs.push_back(static_cast<int>(start));
    is_taken[start] = 1;
    for (std::size_t k = 0; k < outline.arcs.size(); ++k) {
      const auto a = static_cast<std::size_t>(outline.arcs[k]);
      const ContactArc& arc = layout.arcs[a];
      const bool is_left = is_same(arc.left, ratio);
      const auto meets_sheet = [&](double parameter, bool is_begin) {
        ++outline.sheet_ends;
        // On the left of the way into the sheet, the sheet's border runs towards the end.
        const double angle = angle_of(sheet, arc.piece.at(parameter).z);
        (is_begin == is_left ? outline.end : outline.begin) = angle;
      };
      if (arc.begins_at_sheet) meets_sheet(arc.begin, true);
      if (arc.ends_at_sheet) meets_sheet(arc.end, false);
      for (Eigen::Index i = points.first[a]; i < points.first[a + 1]; ++i) {
        const double outward = points.normal_x[i] * points.x[i] + points.normal_y[i] * points.y[i];
        outline.area += (is_left ? 0.5 : -0.5) * outward * points.weight[i];
      }
      for (std::size_t b = 0; b < layout.arcs.size(); ++b) {
        if (is_taken[b] || !bounds(b) || !are_joined(arc, layout.arcs[b])) continue;
        is_taken[b] = 1;
        outline.arcs.push_back(static_cast<int>(b));
      }
    }
    out.push_back(std::move(outline));
  }
  return out;
}

bool covers(const Outline& outline, double angle) {
  return outline.sheet_ends == 2 && turn(outline.begin, angle) < turn(outline.begin, outline.end);
}

/// 1 / (2 mu) less the normal derivative of N, times the points' weights.
MatrixXd system_matrix(const BorderPoints& p, const ArrayXd& half_inverse_mu) {
  const Index count = p.size();
  MatrixXd system(count, count);
  const ArrayXd outward = p.normal_x * p.x + p.normal_y * p.y;
  for (Index j = 0; j < count; ++j) {
    const double scale = p.weight[j] / (2 * pi);
    const double x = p.x[j];
    const double y = p.y[j];
    const double depth = p.depth[j];
    double* column = system.col(j).data();
    for (Index i = 0; i < count; ++i) {
      const double dx = p.x[i] - x;
      const double dy = p.y[i] - y;
      const double square = dx * dx + dy * dy;
      const double along = p.normal_x[i] * dx + p.normal_y[i] * dy;
      // |1 - w conj(v)|^2 = |w - v|^2 + (1 - |w|^2) (1 - |v|^2)
      column[i] =
          scale * (along / square + (along - depth * outward[i]) / (square + depth * p.depth[i]));
    }
    column[j] = half_inverse_mu[j] + scale * (p.curvature[j] / 2 - outward[j] / depth);
  }
  return system;
}

using Complex = std::complex<double>;

/// Angle by which a point that runs along an arc turns about y. `chain` has the arc's ends and
/// points in order.
double angle_turned(const std::vector<Complex>& chain, const Complex& y) {
  int turns = 0;  // counter-clockwise across the negative real axis, where the argument jumps
  Complex last = chain.front() - y;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    const Complex next = chain[i] - y;
    const bool is_above = last.imag() >= 0;
    if (is_above != (next.imag() >= 0)) {
      const double area = last.real() * next.imag() - next.real() * last.imag();
      if (is_above == (area > 0)) turns += is_above ? 1 : -1;
    }
    last = next;
  }
  return std::arg(chain.back() - y) - std::arg(chain.front() - y) + 2 * pi * turns;
}

/// As above for a point of the arc itself, whose passage does not count: at most half a turn,
/// counter-clockwise like the parameter of an ellipse.
double own_angle_turned(const Complex& begin, const Complex& end, const Complex& y) {
  const double angle = std::arg((end - y) / (begin - y));
  return angle > 1e-6 ? angle - pi : angle + pi;
}

/// Corrects a kernel at the points of an arc, where it is large, so that its flux through the arc
/// is exact.
void correct_flux(const ArrayXd& weight, double flux, Eigen::Ref<ArrayXd> kernel) {
  const ArrayXd size = kernel.abs();
  const double sum = (size * weight).sum();
  if (sum > 0) kernel += (flux - (kernel * weight).sum()) / sum * size;
}

/// Makes the fluxes in the equation exact. The flux of a charge through an arc is known: the angle
/// by which a point that runs along the arc turns about the charge and its mirror image. An error
/// of a flux acts as a charge, whose potential grows with the ratio of the conductivities. `slopes`
/// [L, points] of unit charges at `electrodes`.
void conserve_flux(const Sheet& sheet, const BorderLayout& layout,
                   const Eigen::Array2Xd& electrodes, const ArrayXd& half_inverse_mu,
                   BorderSystem& system, MatrixXd& slopes) {
  constexpr double touching = 1e-8;
  const BorderPoints& p = system.points;
  for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
    const ContactArc& arc = layout.arcs[a];
    const Index first = p.first[a];
    const Index count = p.first[a + 1] - first;
    const Complex begin = sheet.to_disc(arc.piece.at(arc.begin).z).w;
    const Complex end = sheet.to_disc(arc.piece.at(arc.end).z).w;
    std::vector<Complex> chain{begin};
    for (Index i = first; i < first + count; ++i) chain.emplace_back(p.x[i], p.y[i]);
    chain.push_back(end);
    const ArrayXd weight = p.weight.segment(first, count);
    for (Index j = 0; j < p.size(); ++j) {
      const bool is_own = j >= first && j < first + count;
      const Complex y(p.x[j], p.y[j]);
      const double mirrored = std::arg((1.0 - end * std::conj(y)) / (1.0 - begin * std::conj(y)));
      double angle = pi;
      if (!is_own)
        angle = angle_turned(chain, y);
      else if (!arc.closed)
        angle = own_angle_turned(begin, end, y);
      ArrayXd kernel = system.matrix.col(j).segment(first, count);
      if (is_own) kernel[j - first] -= half_inverse_mu[j];
      correct_flux(weight, (angle + mirrored) / (2 * pi) * p.weight[j], kernel);
      if (is_own) kernel[j - first] += half_inverse_mu[j];
      system.matrix.col(j).segment(first, count) = kernel;
    }
    for (Index e = 0; e < electrodes.cols(); ++e) {
      const Complex y(electrodes(0, e), electrodes(1, e));
      if (std::abs(begin - y) < touching || std::abs(end - y) < touching) continue;
      ArrayXd kernel = slopes.row(e).segment(first, count).transpose();
      correct_flux(weight, -angle_turned(chain, y) / pi, kernel);
      slopes.row(e).segment(first, count) = kernel.transpose();
    }
  }
}

/// Charges on a region's border that screen its electrodes [points, electrodes]: the solution on
/// that border for zero conductivity inside, from which no current flows out.
MatrixXd screening_charges(const ScreenedRegion& region, const BorderSystem& system,
                           const ArrayXd& half_inverse_mu, const MatrixXd& slopes) {
  std::vector<int> border;
  for (const int arc : region.arcs) {
    for (int i = system.points.first[static_cast<std::size_t>(arc)];
         i < system.points.first[static_cast<std::size_t>(arc) + 1]; ++i) {
      border.push_back(i);
    }
  }
  MatrixXd matrix = system.matrix(border, border);
  for (std::size_t k = 0; k < border.size(); ++k) {
    const auto i = static_cast<Index>(k);
    const double side = system.left[border[k]] == region.ratio ? 0.5 : -0.5;
    matrix(i, i) += side - half_inverse_mu[border[k]];
  }
  MatrixXd charges =
      MatrixXd::Zero(system.points.size(), static_cast<Index>(region.electrodes.size()));
  const MatrixXd right_side = -slopes(region.electrodes, border).transpose();
  const MatrixXd on_border = matrix.partialPivLu().solve(right_side);
  charges(border, Eigen::all) = on_border;
  return charges;
}

}  // namespace

Gathered gathered(std::complex<double> half, const Gathering& gathering) {
  // tan((t - towards) / 2) = strength tan((s - towards) / 2).
  const double c = half.real();
  const double d = gathering.strength * half.imag();
  const double square = c * c + d * d;
  return {{(c * c - d * d) / square, 2 * c * d / square}, gathering.strength / square};
}

Gathering gathering_for(const std::array<double, gathering_probes>& demand, double least) {
  static const std::array<std::complex<double>, gathering_probes> halves = [] {
    std::array<std::complex<double>, gathering_probes> out;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      out[i] = std::polar(1.0, std::numbers::pi * static_cast<double>(i) / gathering_probes);
    }
    return out;
  }();
  const auto worst = std::max_element(demand.begin(), demand.end());
  const auto from_probe = static_cast<std::size_t>(worst - demand.begin());
  Gathering best{1, 2 * std::numbers::pi * static_cast<double>(from_probe) / gathering_probes,
                 std::max(*worst, least)};
  for (const double strength : gathering_strengths) {
    if (best.count <= least) break;
    double count = least;
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      const std::size_t from = (i + gathering_probes - from_probe) % gathering_probes;
      const double c = strength * halves[from].real();
      const double d = halves[from].imag();
      // dt/ds at this t.
      count =
          std::max(count, std::max(demand[i], least_far_off * least) * (c * c + d * d) / strength);
    }
    if (count < best.count) {
      best.count = count;
      best.strength = strength;
    }
  }
  return best;
}

MatrixXd closed_differentiation(int count) {
  MatrixXd out(count, count);
  Eigen::VectorXd by_distance = Eigen::VectorXd::Zero(count);
  for (int distance = 0; distance < count; ++distance) {
    for (int k = 1; 2 * k < count; ++k) {
      by_distance[distance] -= 4 * pi * k / count * std::sin(2 * pi * k * distance / count);
    }
  }
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) out(i, j) = by_distance[(i - j + count) % count];
  }
  return out;
}

std::vector<ScreenedRegion> screened_regions(const Sheet& sheet, const BorderLayout& layout,
                                             const BorderPoints& points,
                                             const Eigen::Array2Xd& electrodes,
                                             const Eigen::ArrayXd& source) {
  std::vector<ScreenedRegion> regions;
  for (Eigen::Index e = 0; e < source.size(); ++e) {
    const double ratio = 1 / source[e];
    if (ratio > 1 || !is_strong(ratio)) continue;
    const double angle = std::atan2(electrodes(1, e), electrodes(0, e));
    const Outline* around = nullptr;
    bool is_plain = true;
    const std::vector<Outline> all = outlines(sheet, layout, points, ratio);
    for (const Outline& outline : all) {
      const bool is_hole = outline.sheet_ends == 0 && outline.area < 0;
      if (is_hole || outline.sheet_ends > 2) is_plain = false;
      if (!covers(outline, angle)) continue;
      if (around) is_plain = false;
      around = &outline;
    }
    if (!around || !is_plain) continue;
    auto region = std::find_if(regions.begin(), regions.end(), [&](const ScreenedRegion& other) {
      return other.arcs == around->arcs && is_same(other.ratio, ratio);
    });
    if (region == regions.end()) {
      const ContactArc& arc = layout.arcs[static_cast<std::size_t>(around->arcs.front())];
      const double exact = is_same(arc.left, ratio) ? arc.left : arc.right;
      region = regions.insert(regions.end(), {around->arcs, {}, exact, {}});
    }
    region->electrodes.push_back(static_cast<int>(e));
  }
  return regions;
}

BorderSystem border_system(const Sheet& sheet, const BorderLayout& layout,
                           const DiscElectrodes& nodes, const ArrayXd& source, double resolution) {
  const Eigen::Array2Xd& electrodes = nodes.places;
  std::vector<int> counts;
  for (const int count : layout.counts) {
    counts.push_back(std::max(3, static_cast<int>(std::ceil(resolution * count - 1e-9))));
  }
  BorderSystem system;
  system.points = border_points(sheet, layout.arcs, counts);
  const BorderPoints& points = system.points;
  const Index count = points.size();
  system.left.resize(count);
  system.right.resize(count);
  for (Index i = 0; i < count; ++i) {
    const int arc = points.arc[static_cast<std::size_t>(i)];
    system.left[i] = layout.arcs[static_cast<std::size_t>(arc)].left;
    system.right[i] = layout.arcs[static_cast<std::size_t>(arc)].right;
  }
  const ArrayXd half_inverse_mu = (system.right + system.left) / (2 * (system.right - system.left));
  system.matrix = system_matrix(points, half_inverse_mu);
  MatrixXd slopes(electrodes.cols(), count);  // of unit charges
  system.potentials.resize(electrodes.cols(), count);
  for (Index e = 0; e < electrodes.cols(); ++e) {
    const ArrayXd dx = points.x - electrodes(0, e);
    const ArrayXd dy = points.y - electrodes(1, e);
    const ArrayXd square = dx.square() + dy.square();
    slopes.row(e) = -1 / pi * (points.normal_x * dx + points.normal_y * dy) / square;
    system.potentials.row(e) = -0.5 / pi * square.log() * points.weight;
  }
  if (std::any_of(layout.arcs.begin(), layout.arcs.end(),
                  [](const ContactArc& arc) { return is_strong(arc.left / arc.right); })) {
    conserve_flux(sheet, layout, electrodes, half_inverse_mu, system, slopes);
  }
  system.screened = screened_regions(sheet, layout, points, electrodes, source);
  ArrayXd charge = source;
  for (const ScreenedRegion& region : system.screened) charge(region.electrodes) = 1;
  system.magnitude = charge.max(1);
  MatrixXd drives = charge.matrix().asDiagonal() * slopes;
  for (ScreenedRegion& region : system.screened) {
    region.charges = screening_charges(region, system, half_inverse_mu, slopes);
    const ArrayXd share = (1 - region.ratio) / (system.right - system.left);
    drives(region.electrodes, Eigen::all) +=
        region.charges.transpose() * share.matrix().asDiagonal();
  }
  system.slopes = nodes.by_nodes() ? drives : nodes.pair_rows(drives);
  return system;
}

}  // namespace ertbench
