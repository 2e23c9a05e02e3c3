#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_layout.h"
#include "forward/border/border_model.h"
#include "forward/border/border_system.h"
#include "forward/border/contact_electrodes.h"

namespace ertbench {
namespace {

using Eigen::AlignedBox2d;
using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;

using Complex = std::complex<double>;

/// Normal displacement of a border times the quadrature weight of a point, for unit changes of all
/// entries of ContactMotion except the ratio.
Eigen::Array<double, ContactMotion::log_ratio, 1> motion(const Complex& from_centroid,
                                                         const Complex& tangent) {
  const Complex normal(tangent.imag(), -tangent.real());  // to the right, times the length
  const auto along = [&](Complex shift) { return (std::conj(normal) * shift).real(); };
  const Complex i(0, 1);
  return {along(1),
          along(i),
          along(from_centroid),
          along(i * from_centroid),
          along(std::conj(from_centroid)),
          along(i * std::conj(from_centroid))};
}

/// Number of bisections next to an electrode; the last box contributes 1e-4 of the pixel's
/// integral.
constexpr int halvings_at_electrodes = 12;
/// Number of bisections at the sheet's border; after that a box counts by its area and its centre.
constexpr int halvings_at_border = 5;
constexpr Index points_at_once = 64;
/// Gauss points on [-1, 1].
constexpr std::array<double, 4> abscissae{-0.8611363115940526, -0.3399810435848563,
                                          0.3399810435848563, 0.8611363115940526};
constexpr std::array<double, 4> gauss_weights{0.3478548451374538, 0.6521451548625461,
                                              0.6521451548625461, 0.3478548451374538};

/// Integrals over boxes of the products of two pairs' fields.
class FieldProducts {
 public:
  explicit FieldProducts(const Sensor& sensor)
      : sheet_(*sensor.sheet),
        nodes_(sensor, Eigen::VectorXd::Zero(sensor.electrode_count)),
        background_(sensor.background) {
    by_node_.resize(nodes_.nodes(), 2 * points_at_once);
    // [electrodes, nodes] distribution of each electrode's current.
    shares_ = Eigen::MatrixXd::Identity(nodes_.nodes(), nodes_.nodes());
    if (nodes_.currents.size() > 0) shares_ = nodes_.currents.transpose();
    sum_ = MatrixXd::Zero(shares_.rows(), shares_.rows());
  }

  /// Integral over the part of the box on the sheet, [channels].
  Eigen::VectorXd integral(const AlignedBox2d& box) {
    add(box, 0);
    return of_channels();
  }

  Eigen::VectorXd at(const Vector2d& place) {
    add_point(place, 1);
    return of_channels();
  }

 private:
  /// The sum so far, from which the next one begins anew.
  Eigen::VectorXd of_channels() {
    add_points();
    const MatrixXd by_pairs = nodes_.differences(nodes_.differences(sum_).transpose());
    Eigen::VectorXd out(static_cast<Index>(nodes_.channels.size()));
    for (std::size_t c = 0; c < nodes_.channels.size(); ++c) {
      const auto& [measurement, drive] = nodes_.channels[c];
      out[static_cast<Index>(c)] = nodes_.volts[c] / background_ * by_pairs(measurement, drive);
    }
    sum_.setZero();
    return out;
  }

  void add(const AlignedBox2d& box, int halvings) {
    const bool is_whole = sheet_.encloses(box, -1e-12);
    double part = 1;
    if (!is_whole) {
      part = sheet_.area_within(box) / box.volume();
      if (part <= 0) return;
    }
    const bool at_electrode = halvings < halvings_at_electrodes && is_near_electrode(box);
    if (at_electrode || (!is_whole && halvings < halvings_at_border)) {
      const Vector2d half = box.sizes() / 2;
      for (const double x : {0.0, 1.0}) {
        for (const double y : {0.0, 1.0}) {
          const Vector2d low = box.min() + Vector2d(x, y).cwiseProduct(half);
          add({low, low + half}, halvings + 1);
        }
      }
    } else if (!is_whole) {
      const Vector2d middle = box.center();
      // If the centre is off the sheet, the part on the sheet lies next to the border.
      const double beyond = std::max(0.0, -sheet_.depth(middle));
      const Vector2d inwards = (sheet_.bounds().center() - middle).normalized();
      add_point(middle + (beyond > 0 ? beyond + 1e-9 : 0) * inwards, part * box.volume());
    } else {
      for (std::size_t i = 0; i < abscissae.size(); ++i) {
        for (std::size_t j = 0; j < abscissae.size(); ++j) {
          const Vector2d offset(abscissae[i], abscissae[j]);
          add_point(box.center() + offset.cwiseProduct(box.sizes()) / 2,
                    gauss_weights[i] * gauss_weights[j] / 4 * box.volume());
        }
      }
    }
  }

  bool is_near_electrode(const AlignedBox2d& box) const {
    const double near = box.sizes().squaredNorm();
    for (Index n = 0; n < nodes_.nodes(); ++n) {
      if (box.squaredExteriorDistance(nodes_.positions.col(n)) < near) return true;
    }
    return false;
  }

  void add_point(const Vector2d& place, double weight) {
    const DiscPoint point = sheet_.to_disc({place.x(), place.y()});
    // The gradient of -ln|w - e| / pi, times the map's slope, conjugated: s / d with d = w - e.
    const Complex slope = -std::sqrt(weight) / std::numbers::pi * point.first;
    const ArrayXd dx = point.w.real() - nodes_.places.row(0).transpose();
    const ArrayXd dy = point.w.imag() - nodes_.places.row(1).transpose();
    const ArrayXd over_square = (dx.square() + dy.square()).inverse();
    by_node_.col(waiting_++) = (slope.real() * dx + slope.imag() * dy) * over_square;
    by_node_.col(waiting_++) = (slope.imag() * dx - slope.real() * dy) * over_square;
    if (waiting_ == by_node_.cols()) add_points();
  }

  void add_points() {
    const MatrixXd by_electrode = shares_ * by_node_.leftCols(waiting_);
    sum_.noalias() += by_electrode * by_electrode.transpose();
    waiting_ = 0;
  }

  const Sheet& sheet_;
  DiscElectrodes nodes_;
  double background_;
  Eigen::MatrixXd shares_;
  Eigen::MatrixXd by_node_;  ///< [nodes, two for each of the points that wait to be added]
  Index waiting_ = 0;
  Eigen::MatrixXd sum_;
};

}  // namespace

BorderModel::Linearisation BorderModel::linearise(const Scene& scene, double resolution) const {
  Linearisation out;
  out.change = Eigen::VectorXd::Zero(sensor_.channels());
  out.derivatives = RowMajorMatrix::Zero(
      sensor_.channels(), ContactMotion::count * static_cast<Index>(scene.contacts.size()));
  const Eigen::VectorXd ratios = electrode_ratios(scene);
  for (Index e = 0; e < ratios.size(); ++e) {
    if (ratios[e] != 1) {
      throw InputError("electrode " +
                       std::to_string(nodes_.electrodes[static_cast<std::size_t>(e)]) +
                       ": derivatives are for scenes in which no contact covers an electrode");
    }
  }
  // The tangential derivative of a smooth border would be lost at a cut.
  const BorderLayout layout = border_layout(*sensor_.sheet, nodes_.places, scene, BorderCuts::none);
  for (const ContactArc& arc : layout.arcs) {
    if (!arc.closed) {
      throw InputError("contact " + std::to_string(arc.contact) +
                       ": derivatives are for discs and ellipses that lie whole inside the sheet "
                       "and cross no other contact");
    }
  }
  if (layout.arcs.empty()) return out;
  const BorderSystem system =
      border_system(*sensor_.sheet, layout, nodes_, ArrayXd::Ones(nodes_.nodes()), resolution);
  const BorderPoints& points = system.points;
  out.points = static_cast<int>(points.size());
  const auto factor = conductors_matrix(system).partialPivLu();
  const MatrixXd slopes = nodes_.by_nodes() ? nodes_.pair_rows(system.slopes) : system.slopes;
  const MatrixXd density = factor.solve(slopes.transpose());        // [points, pairs]
  const MatrixXd potentials = nodes_.pair_rows(system.potentials);  // [pairs, points]
  out.change = reciprocal_mean(potentials * density, system.magnitude).change;
  // The solution y of the transposed equation, over its weights, gives the potential u = y / (r -
  // l).
  const MatrixXd transposed = factor.transpose().solve(potentials.transpose());
  const ArrayXd jump = system.right - system.left;
  const MatrixXd potential = (points.weight * jump).inverse().matrix().asDiagonal() * transposed;
  // Current density through the border: r d_n u on one side, l d_n u on the other.
  const MatrixXd current = (system.left * system.right / jump).matrix().asDiagonal() * density;

  const auto add = [&](const MatrixXd& products, Index column) {
    out.derivatives.col(column) -=
        voltages(products);  // V = -I/c0 (...), dV/dratio = +I/c0 grad u . grad u
  };
  for (std::size_t a = 0; a < layout.arcs.size(); ++a) {
    const ContactArc& arc = layout.arcs[a];
    const Index first = points.first[a];
    const Index count = points.first[a + 1] - first;
    const auto u = potential.middleRows(first, count);
    const auto q = current.middleRows(first, count);
    const int steps = static_cast<int>(count);
    MatrixXd along = closed_differentiation(steps) * u;  // d_t u on the sheet
    MatrixXd across = q;                                 // the current there
    Eigen::Array<double, ContactMotion::log_ratio, Eigen::Dynamic> moved(
        static_cast<int>(ContactMotion::log_ratio), count);
    const Eigen::Vector2d centre = scene.contacts[static_cast<std::size_t>(arc.contact)].centroid();
    for (Index i = 0; i < count; ++i) {
      const Graded graded = graded_parameter(arc, static_cast<int>(i), static_cast<int>(count));
      const BorderPoint border = arc.piece.at(graded.parameter);
      const Complex step = border.first * graded.speed;  // dz/ds
      along.row(i) /= std::abs(step);
      across.row(i) *= points.weight[first + i] * static_cast<double>(count) / std::abs(step);
      moved.col(i) =
          motion(border.z - Complex(centre.x(), centre.y()), step / static_cast<double>(count));
    }
    // A border that moves to the right gains (l - r) (d_t u d_t u + q q / (l r)) on its left.
    for (Index parameter = 0; parameter < ContactMotion::log_ratio; ++parameter) {
      const Eigen::VectorXd gain = (arc.left - arc.right) * moved.row(parameter).transpose();
      add(along.transpose() * gain.asDiagonal() * along +
              across.transpose() * (gain / (arc.left * arc.right)).asDiagonal() * across,
          arc.contact * ContactMotion::count + parameter);
    }
    // int grad u . grad u over the region on either side, as an integral over its border.
    const MatrixXd flux =
        u.transpose() * points.weight.segment(first, count).matrix().asDiagonal() * q;
    if (arc.left_contact >= 0) {
      add(flux, arc.left_contact * ContactMotion::count + ContactMotion::log_ratio);
    }
    if (arc.right_contact >= 0) {
      add(-flux, arc.right_contact * ContactMotion::count + ContactMotion::log_ratio);
    }
  }
  for (const auto& [a, b] : pairs_) {
    const Eigen::RowVectorXd mean = (out.derivatives.row(a) + out.derivatives.row(b)) / 2;
    out.derivatives.row(a) = mean;
    out.derivatives.row(b) = mean;
  }
  return out;
}

RowMajorMatrix border_jacobian(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  RowMajorMatrix jacobian = RowMajorMatrix::Zero(sensor.channels(), pixels.count());
  FieldProducts products(sensor);
  for (int p = 0; p < pixels.count(); ++p) {
    if (pixels.on_sheet(p)) jacobian.col(p) = products.integral(pixels.box(p));
  }
  return jacobian;
}

Eigen::MatrixXd border_sensitivity(const Sensor& sensor,
                                   const std::vector<Eigen::Vector2d>& places) {
  FieldProducts products(sensor);
  Eigen::MatrixXd out(sensor.channels(), std::ssize(places));
  for (Index p = 0; p < out.cols(); ++p) {
    out.col(p) = products.at(places[static_cast<std::size_t>(p)]);
  }
  return out;
}

}  // namespace ertbench
