#include "forward/border/border_jacobian.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "forward/border/disc_electrodes.h"

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using Eigen::AlignedBox2d;
using Eigen::Index;
using Eigen::Vector2d;

/// Boxes next to an electrode are halved so often: what is left there is 1e-4 of the pixel's.
constexpr int halvings_at_electrodes = 12;
/// Boxes that the sheet's border crosses: beyond that each counts by its area and its middle.
constexpr int halvings_at_border = 5;
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
        scale_(sensor.drive_current / (sensor.background * sensor.background)) {
    for (Index n = 0; n < nodes_.nodes(); ++n) {
      places_.emplace_back(nodes_.places(0, n), nodes_.places(1, n));
    }
    const auto pairs = static_cast<Index>(nodes_.pairs.size());
    by_node_.resize(nodes_.nodes(), 2);
    by_pair_.resize(pairs, 2);
    // [pairs, nodes] how each pair's current is shared out.
    shares_ = nodes_.pair_rows(Eigen::MatrixXd::Identity(nodes_.nodes(), nodes_.nodes()));
    sum_.resize(pairs, pairs);
  }

  /// Of the part of the box that is on the sheet, [channels].
  Eigen::VectorXd integral(const AlignedBox2d& box) {
    sum_.setZero();
    add(box, 0);
    return of_channels();
  }

  Eigen::VectorXd at(const Vector2d& place) {
    sum_.setZero();
    add_point(place, 1);
    return of_channels();
  }

 private:
  Eigen::VectorXd of_channels() const {
    Eigen::VectorXd out(static_cast<Index>(nodes_.channels.size()));
    for (std::size_t c = 0; c < nodes_.channels.size(); ++c) {
      const auto& [measurement, drive] = nodes_.channels[c];
      out[static_cast<Index>(c)] = scale_ * sum_(measurement, drive);
    }
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
      // Of a box whose middle is off the sheet, the part on it is beside the border.
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
    for (std::size_t n = 0; n < places_.size(); ++n) {
      // The gradient of -ln|w - e| / pi, times the map's slope, conjugated.
      const Complex field = -point.first / (std::numbers::pi * (point.w - places_[n]));
      by_node_.row(static_cast<Index>(n)) << field.real(), field.imag();
    }
    by_pair_.noalias() = shares_ * by_node_;
    sum_.noalias() += weight * by_pair_ * by_pair_.transpose();
  }

  const Sheet& sheet_;
  DiscElectrodes nodes_;
  double scale_;
  std::vector<Complex> places_;
  Eigen::MatrixXd shares_;
  Eigen::MatrixX2d by_node_;
  Eigen::MatrixX2d by_pair_;
  Eigen::MatrixXd sum_;
};

}  // namespace

RowMajorMatrix border_jacobian(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  RowMajorMatrix jacobian = RowMajorMatrix::Zero(sensor.channels(), pixels.count());
  FieldProducts products(sensor);
  for (int p = 0; p < pixels.count(); ++p) {
    if (pixels.on_sheet(p)) jacobian.col(p) = products.integral(pixels.box(p));
  }
  return jacobian;
}

Eigen::VectorXd border_sensitivity(const Sensor& sensor, const Eigen::Vector2d& place) {
  return FieldProducts(sensor).at(place);
}

}  // namespace ertbench
