#include "forward/ellipses/ellipse_model.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/arrays.h"
#include "forward/border/differentiation.h"
#include "forward/ellipses/ellipse_memory.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

}  // namespace

EllipseModel::Workspace::Workspace() : memory_(std::make_unique<Memory>()) {}
EllipseModel::Workspace::~Workspace() = default;
EllipseModel::Workspace::Workspace(Workspace&&) noexcept = default;
EllipseModel::Workspace& EllipseModel::Workspace::operator=(Workspace&&) noexcept = default;
int EllipseModel::Workspace::points() const { return memory_->points; }

EllipseModel::EllipseModel(const Sensor& sensor) : EllipseModel(sensor, Options{}) {}

EllipseModel::EllipseModel(const Sensor& sensor, const Options& options)
    : sensor_(sensor),
      options_(options),
      nodes_(sensor, Eigen::VectorXd::Zero(sensor.electrode_count)),
      stride_((static_cast<int>(nodes_.pairs.size()) + RowLu::lanes - 1) / RowLu::lanes *
              RowLu::lanes),
      differentiation_(static_cast<std::size_t>(std::max(options.most_points, least_points)) + 1),
      halves_(differentiation_.size()) {
  for (Index n = 0; n < nodes_.nodes(); ++n) {
    x_.push_back(nodes_.places(0, n));
    y_.push_back(nodes_.places(1, n));
  }
  for (const auto& pair : reciprocal_pairs(sensor)) {
    pairs_.push_back(nodes_.channels[static_cast<std::size_t>(pair[0])]);
  }
  for (int n = least_points; n <= std::max(options.most_points, least_points); n += 2) {
    differentiation_[static_cast<std::size_t>(n)] = closed_differentiation(n) / (2 * pi);
    for (int i = 0; i < n; ++i) {
      halves_[static_cast<std::size_t>(n)].push_back(std::polar(1.0, pi * i / n));
    }
  }
}

EllipseModel::~EllipseModel() = default;

void EllipseModel::assemble(Workspace::Memory& m) const {
  const int count = m.points;
  const auto n = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < n; ++i) {
    double* row = m.matrix.row(static_cast<int>(i));
    const double x = m.x[i];
    const double y = m.y[i];
    const double normal_x = m.normal_x[i];
    const double normal_y = m.normal_y[i];
    const double depth = m.depth[i];
    const double outward = normal_x * x + normal_y * y;
    for (std::size_t j = 0; j < n; ++j) {
      const double dx = x - m.x[j];
      const double dy = y - m.y[j];
      const double square = dx * dx + dy * dy;
      const double along = normal_x * dx + normal_y * dy;
      // |1 - w conj(v)|^2 = |w - v|^2 + (1 - |w|^2) (1 - |v|^2)
      row[j] = m.weight[j] / (2 * pi) *
               (along / (square + (square == 0 ? 1.0 : 0.0)) +
                (along - m.depth[j] * outward) / (square + m.depth[j] * depth));
    }
  }
  for (const auto& border : m.borders) {
    const double half_inverse_mu = (1 + border.ratio) / (2 * (1 - border.ratio));
    for (int i = border.first; i < border.first + border.count; ++i) {
      const auto p = static_cast<std::size_t>(i);
      m.matrix.row(i)[i] += half_inverse_mu + m.weight[p] / (2 * pi) * m.curvature[p] / 2;
    }
  }
  place_sources(m);
  if (nodes_.is_complete()) add_conductors(m);
}

/// The drives' fields across the borders, and the borders' potentials at the measuring pairs.
void EllipseModel::place_sources(Workspace::Memory& m) const {
  const auto n = static_cast<std::size_t>(m.points);
  const auto wide = static_cast<std::size_t>(stride_);
  const auto nodes = x_.size();
  m.slopes.resize(m.points, nodes_.nodes());
  m.charges.resize(m.points, nodes_.nodes());
  for (std::size_t i = 0; i < n; ++i) {
    double* slope = m.slopes.row(static_cast<Index>(i)).data();
    double* charge = m.charges.row(static_cast<Index>(i)).data();
    for (std::size_t e = 0; e < nodes; ++e) {
      const double dx = m.x[i] - x_[e];
      const double dy = m.y[i] - y_[e];
      const double square = dx * dx + dy * dy;
      slope[e] = -1 / pi * (m.normal_x[i] * dx + m.normal_y[i] * dy) / square;
      charge[e] = square;
    }
    for (std::size_t e = 0; e < nodes; ++e) {
      charge[e] = -0.5 / pi * m.weight[i] * std::log(charge[e]);
    }
  }
  const auto by_pairs = [&](const RowMajorMatrix& by_nodes, std::vector<double>& out) {
    const RowMajorMatrix* rows = &by_nodes;
    if (nodes_.currents.size() > 0) {
      m.by_electrode.noalias() = by_nodes * nodes_.currents;
      rows = &m.by_electrode;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const double* row = rows->row(static_cast<Index>(i)).data();
      double* pair = &out[i * wide];
      for (std::size_t k = 0; k < nodes_.pairs.size(); ++k) {
        pair[k] = row[nodes_.pairs[k].second] - row[nodes_.pairs[k].first];
      }
      for (std::size_t k = nodes_.pairs.size(); k < wide; ++k) pair[k] = 0;
    }
  };
  by_pairs(m.slopes, m.density);
  by_pairs(m.charges, m.potential);
}

/// The electrodes that conduct share their currents out anew: N becomes that of the sheet with its
/// conductors (DiscElectrodes::redistribution), and its slope enters with the other sign.
void EllipseModel::add_conductors(Workspace::Memory& m) const {
  const RowMajorMatrix slopes = m.slopes * nodes_.redistribution;
  const RowMajorMatrix charges = m.charges * nodes_.redistribution;
  const RowMajorMatrix added = slopes * charges.transpose();
  for (int i = 0; i < m.points; ++i) {
    for (int j = 0; j < m.points; ++j) m.matrix.row(i)[j] += added(i, j);
  }
}

void EllipseModel::evaluate(Workspace& workspace, Eigen::Ref<Eigen::VectorXd> change) const {
  Workspace::Memory& m = *workspace.memory_;
  assemble(m);
  m.matrix.factor();
  m.matrix.solve(m.density, stride_);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Map<const RowMajor> density(m.density.data(), m.points, stride_);
  const Eigen::Map<const RowMajor> potential(m.potential.data(), m.points, stride_);
  m.impedance.resize(stride_, stride_);
  m.impedance.noalias() = potential.transpose().lazyProduct(density);
  const double volts = -sensor_.drive_current / sensor_.background;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const auto& [a, b] = pairs_[p];
    change[static_cast<Index>(p)] = volts / 2 * (m.impedance(a, b) + m.impedance(b, a));
  }
}

}  // namespace ertbench
