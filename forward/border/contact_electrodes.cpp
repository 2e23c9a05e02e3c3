#include "forward/border/contact_electrodes.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <utility>

namespace ertbench {

EllipticContact::Vector EllipticContact::vector() const {
  Vector out;
  out << centre, log_size, stretch, log_ratio;
  return out;
}

EllipticContact EllipticContact::from(const Eigen::Ref<const Vector>& vector) {
  return {vector.head<2>(), vector[2], vector.segment<2>(3), vector[5]};
}

Eigen::Vector2d EllipticContact::half_axes() const {
  const double half_log_aspect = stretch.norm();
  return {std::exp(log_size + half_log_aspect), std::exp(log_size - half_log_aspect)};
}

double EllipticContact::angle() const {
  // Without a stretch the angle is undefined, and atan2 gives 0.
  return std::atan2(stretch.y(), stretch.x()) / 2;
}

double EllipticContact::ratio() const { return std::exp(log_ratio); }

double EllipticContact::area() const { return std::numbers::pi * std::exp(2 * log_size); }

Contact EllipticContact::contact() const {
  Contact out;
  out.shape = Shape::ellipse;
  out.centre = centre;
  out.half_size = half_axes();
  out.angle = angle();
  out.conductivity_ratio = ratio();
  return out;
}

Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> motion_of(
    const EllipticContact& contact) {
  Eigen::Matrix<double, ContactMotion::count, EllipticContact::parameters> out;
  out.setZero();
  out(ContactMotion::x, 0) = 1;
  out(ContactMotion::y, 1) = 1;
  out(ContactMotion::growth, 2) = 1;
  out(ContactMotion::log_ratio, 5) = 1;
  // In the axes of the ellipse, with half axes a, b and m = log(a / b) / 2: a diagonal change of M
  // is a strain of the ellipse. An off-diagonal change d changes exp(M) by d (a - b) / (2 m), which
  // acts as the strain d (a^2 - b^2) / (2 m (a^2 + b^2)) = d tanh(2 m) / (2 m).
  const double m = contact.stretch.norm();
  const double across = m > 1e-4 ? std::tanh(2 * m) / (2 * m) : 1 - 4 * m * m / 3;
  const Eigen::Vector2d axis = m > 0 ? Eigen::Vector2d(contact.stretch / m) : Eigen::Vector2d(1, 0);
  const Eigen::Vector2d other(-axis.y(), axis.x());
  out.block<2, 2>(ContactMotion::stretch, 3) =
      axis * axis.transpose() + across * other * other.transpose();
  return out;
}

Scene scene_of(std::span<const EllipticContact> contacts) {
  Scene scene;
  for (const EllipticContact& contact : contacts) scene.contacts.push_back(contact.contact());
  return scene;
}

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;

constexpr int gap_nodes = 6;
constexpr int complete_nodes = 12;

int nodes_of(ElectrodeModel model) {
  if (model == ElectrodeModel::point) return 1;
  return model == ElectrodeModel::gap ? gap_nodes : complete_nodes;
}

/// Angles of the Chebyshev nodes: t = -cos(angle).
VectorXd node_angles(int count) {
  VectorXd out(count);
  for (int i = 0; i < count; ++i) out[i] = pi * (i + 0.5) / count;
  return out;
}

/// Fejer's first rule for means over [-1, 1].
VectorXd mean_weights(const VectorXd& angles) {
  const auto count = static_cast<int>(angles.size());
  VectorXd out = VectorXd::Ones(count);
  for (int k = 1; 2 * k <= count; ++k) {
    for (int i = 0; i < count; ++i) out[i] -= 2 * std::cos(2 * k * angles[i]) / (4.0 * k * k - 1);
  }
  return out / out.sum();
}

/// -ln|t - s| for currents at the nodes, as it acts on cosines of their angles: the kernel is
/// ln 2 + sum over k of (2 / k) cos k angle(t) cos k angle(s).
MatrixXd logarithm(const VectorXd& angles) {
  const Index count = angles.size();
  MatrixXd out = MatrixXd::Constant(count, count, std::numbers::ln2);
  for (Index k = 1; k < count; ++k) {
    const VectorXd cosines = (static_cast<double>(k) * angles.array()).cos();
    out += 2 / static_cast<double>(k) * cosines * cosines.transpose();
  }
  return out;
}

/// Sets the blocks of N between nodes of one electrode, where its logarithm is singular. Without
/// the logarithm of the distance along the border the rest is smooth.
void add_own_blocks(const VectorXd& angles, double half_width, const VectorXd& speeds,
                    DiscElectrodes& out) {
  const Index count = angles.size();
  const MatrixXd own = logarithm(angles);
  for (Index first = 0; first < out.nodes(); first += count) {
    for (Index i = 0; i < count; ++i) {
      for (Index j = 0; j < count; ++j) {
        double stretch = half_width * speeds[first + i];
        if (i != j) {
          const double distance =
              (out.places.col(first + i) - out.places.col(first + j)).matrix().norm();
          stretch = distance / std::abs(std::cos(angles[i]) - std::cos(angles[j]));
        }
        out.neumann(first + i, first + j) = (own(i, j) - std::log(stretch)) / pi;
      }
    }
  }
}

void share_evenly(const VectorXd& weights, Index electrodes, DiscElectrodes& out) {
  out.currents = MatrixXd::Zero(out.nodes(), electrodes);
  for (Index n = 0; n < out.nodes(); ++n) {
    out.currents(n, out.electrodes[static_cast<std::size_t>(n)]) = weights[n % weights.size()];
  }
  out.potentials = out.currents.transpose() * out.neumann * out.currents;
}

void let_conduct(const Sensor& sensor, const VectorXd& weights, const VectorXd& impedances,
                 DiscElectrodes& out) {
  // In domain units, for a sheet of conductivity 1.
  const double impedance =
      sensor.contact_impedance * sensor.background / (sensor.sheet->unit_mm() / 1000);
  const Index nodes = out.nodes();
  MatrixXd whose = MatrixXd::Zero(nodes, sensor.electrode_count);
  // Potentials are defined up to a constant; this one makes the matrix positive definite.
  out.with_contacts = out.neumann + MatrixXd::Ones(nodes, nodes);
  for (Index n = 0; n < nodes; ++n) {
    const int electrode = out.electrodes[static_cast<std::size_t>(n)];
    whose(n, electrode) = 1;
    const double relative = impedances.size() > 0 ? impedances[electrode] : 1;
    out.with_contacts(n, n) +=
        relative * impedance / (weights[n % weights.size()] * sensor.electrode_width);
  }
  const MatrixXd inverse = out.with_contacts.partialPivLu().inverse();
  const MatrixXd spread = inverse * whose;
  out.potentials = (whose.transpose() * spread).partialPivLu().inverse();
  out.currents = spread * out.potentials;
  const MatrixXd free = inverse - out.currents * spread.transpose();
  out.redistribution = (free + free.transpose()) / 2;
}

}  // namespace

DiscElectrodes::DiscElectrodes(const Sensor& sensor, const VectorXd& displacement,
                               const VectorXd& impedances) {
  const int each = nodes_of(sensor.electrode_model);
  const VectorXd angles = node_angles(each);
  const VectorXd middles = electrode_distances(sensor);
  const double half_width = sensor.electrode_width / 2;
  const Index count = Index{each} * sensor.electrode_count;
  positions.resize(2, count);
  places.resize(2, count);
  VectorXd speeds(count);
  for (Index n = 0; n < count; ++n) {
    const Index e = n / each;
    electrodes.push_back(static_cast<int>(e));
    const double along = each == 1 ? 0 : -half_width * std::cos(angles[n % each]);
    positions.col(n) = sensor.sheet->border_point(middles[e] + displacement[e] + along);
    const DiscPoint point = sensor.sheet->to_disc({positions(0, n), positions(1, n)});
    places.col(n) << point.w.real() / std::abs(point.w), point.w.imag() / std::abs(point.w);
    speeds[n] = std::abs(point.first);
  }
  neumann = MatrixXd::Zero(count, count);
  for (Index e = 0; e < count; ++e) {
    for (Index f = 0; f < e; ++f) {
      const double distance = (places.col(e) - places.col(f)).matrix().norm();
      neumann(e, f) = neumann(f, e) = -std::log(distance) / pi;
    }
  }
  SensorPairs of_sensor(sensor);
  pairs = std::move(of_sensor.pairs);
  channels = std::move(of_sensor.channels);
  volts = std::move(of_sensor.currents);
  for (double& value : volts) value /= sensor.background;
  if (sensor.electrode_model == ElectrodeModel::point) {
    potentials = neumann;
    return;
  }
  const VectorXd weights = mean_weights(angles);
  add_own_blocks(angles, half_width, speeds, *this);
  if (sensor.electrode_model == ElectrodeModel::gap) {
    share_evenly(weights, sensor.electrode_count, *this);
  } else {
    let_conduct(sensor, weights, impedances, *this);
  }
}

MatrixXd DiscElectrodes::differences(const MatrixXd& rows) const {
  MatrixXd out(static_cast<Index>(pairs.size()), rows.cols());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    out.row(static_cast<Index>(k)) = rows.row(pairs[k].second) - rows.row(pairs[k].first);
  }
  return out;
}

MatrixXd DiscElectrodes::pair_rows(const MatrixXd& rows) const {
  if (currents.size() == 0) return differences(rows);
  return differences(currents.transpose() * rows);
}

MatrixXd DiscElectrodes::pair_matrix(const MatrixXd& by_nodes) const {
  return pair_rows(pair_rows(by_nodes.transpose()).transpose());
}

MatrixXd DiscElectrodes::currents_where(const MatrixXd& change) const {
  MatrixXd whose = MatrixXd::Zero(nodes(), currents.cols());
  for (Index n = 0; n < nodes(); ++n) whose(n, electrodes[static_cast<std::size_t>(n)]) = 1;
  const MatrixXd spread = (with_contacts + change).partialPivLu().solve(whose);
  return spread * (whose.transpose() * spread).partialPivLu().inverse();
}

}  // namespace ertbench
