#include "forward/ellipses/ellipse_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "forward/border/border_system.h"

namespace ertbench {
namespace {

using Eigen::Index;
using std::numbers::pi;

using Complex = std::complex<double>;

constexpr int strains = 5;  // x, y, growth, stretch, shear
constexpr int lanes = RowLu::lanes;
using Lanes = Eigen::Array<double, lanes, 1>;

Complex shift_by(int strain, Complex from_centre) {
  switch (strain) {
    case 0:
      return {1, 0};
    case 1:
      return {0, 1};
    case 2:
      return from_centre;
    case 3:
      return std::conj(from_centre);
    default:
      return Complex(0, 1) * std::conj(from_centre);
  }
}

/// Sums over the points i of gains[strain, i] (along[i, a] along[i, b] + across[i, a] across[i, b])
/// into products[strain, a, b], for b in the vectors from that of a on: they are symmetric.
void sum_products(const double* along, const double* across, const double* gains, int points,
                  int width, double* products) {
  const auto at = [width](const double* rows, int row, int column) {
    return Eigen::Map<const Lanes>(rows + static_cast<std::ptrdiff_t>(row) * width + column);
  };
  for (int a = 0; a < width; ++a) {
    for (int b = a / lanes * lanes; b < width; b += lanes) {
      Lanes sum0 = Lanes::Zero();
      Lanes sum1 = sum0;
      Lanes sum2 = sum0;
      Lanes sum3 = sum0;
      Lanes sum4 = sum0;
      for (int i = 0; i < points; ++i) {
        const Lanes product =
            along[i * width + a] * at(along, i, b) + across[i * width + a] * at(across, i, b);
        const double* gain = gains + static_cast<std::ptrdiff_t>(i) * strains;
        sum0 += gain[0] * product;
        sum1 += gain[1] * product;
        sum2 += gain[2] * product;
        sum3 += gain[3] * product;
        sum4 += gain[4] * product;
      }
      const auto out = [&](int strain) {
        return Eigen::Map<Lanes>(products + (strain * width + a) * width + b);
      };
      out(0) = sum0;
      out(1) = sum1;
      out(2) = sum2;
      out(3) = sum3;
      out(4) = sum4;
    }
  }
}

}  // namespace

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
    volts_.push_back(nodes_.volts[static_cast<std::size_t>(pair[0])]);
  }
  for (int n = least_points; n <= std::max(options.most_points, least_points); n += 2) {
    differentiation_[static_cast<std::size_t>(n)] = closed_differentiation(n) / (2 * pi);
    for (int i = 0; i < n; ++i) {
      halves_[static_cast<std::size_t>(n)].push_back(std::polar(1.0, pi * i / n));
    }
  }
}

void EllipseModel::assemble(Workspace& m) const {
  const int count = m.unknowns;
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
void EllipseModel::place_sources(Workspace& m) const {
  const auto n = static_cast<std::size_t>(m.unknowns);
  const auto wide = static_cast<std::size_t>(stride_);
  const auto nodes = x_.size();
  m.slopes.resize(m.unknowns, nodes_.nodes());
  m.charges.resize(m.unknowns, nodes_.nodes());
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

/// Accounts for the redistribution of currents by conducting electrodes: N becomes that of the
/// sheet with its conductors (DiscElectrodes::redistribution), whose slope enters with the opposite
/// sign.
void EllipseModel::add_conductors(Workspace& m) const {
  const RowMajorMatrix slopes = m.slopes * nodes_.redistribution;
  const RowMajorMatrix added = slopes * m.charges.transpose();
  for (int i = 0; i < m.unknowns; ++i) {
    for (int j = 0; j < m.unknowns; ++j) m.matrix.row(i)[j] += added(i, j);
  }
}

void EllipseModel::evaluate(Workspace& m, Eigen::Ref<Eigen::VectorXd> change) const {
  assemble(m);
  m.matrix.factor();
  m.matrix.solve(m.density, stride_);
  const Eigen::Map<const RowMajorMatrix> density(m.density.data(), m.unknowns, stride_);
  const Eigen::Map<const RowMajorMatrix> potential(m.potential.data(), m.unknowns, stride_);
  m.impedance.resize(stride_, stride_);
  m.impedance.noalias() = potential.transpose().lazyProduct(density);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const auto& [a, b] = pairs_[p];
    change[static_cast<Index>(p)] = -volts_[p] / 2 * (m.impedance(a, b) + m.impedance(b, a));
  }
}

void EllipseModel::derivatives(Workspace& m, Eigen::Ref<Eigen::MatrixXd> out) const {
  const auto wide = static_cast<std::size_t>(stride_);
  std::copy_n(m.potential.begin(), static_cast<std::ptrdiff_t>(wide) * m.unknowns,
              m.solution.begin());
  m.matrix.solve_transposed(m.solution, stride_);
  m.products.resize(strains * wide * wide);
  for (std::size_t k = 0; k < m.borders.size(); ++k) {
    const auto& border = m.borders[k];
    const auto first = static_cast<std::size_t>(border.first);
    const double jump = 1 - border.ratio;
    // u = y / (weight (r - l)), and the current l r / (r - l) density; see BorderModel::linearise.
    Eigen::Map<RowMajorMatrix> u(&m.solution[first * wide], border.count, stride_);
    Eigen::Map<RowMajorMatrix> q(&m.density[first * wide], border.count, stride_);
    Eigen::Map<RowMajorMatrix> along(&m.along[first * wide], border.count, stride_);
    for (int i = 0; i < border.count; ++i) {
      const auto p = first + static_cast<std::size_t>(i);
      u.row(i) *= 1 / (m.weight[p] * jump);
      // Current through the border, times the point's weight.
      q.row(i) *= border.ratio / jump * m.weight[p];
    }
    auto columns = out.middleCols(static_cast<Index>(k) * EllipticContact::parameters,
                                  EllipticContact::parameters);
    m.impedance.noalias() = u.transpose().lazyProduct(q);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto& [a, b] = pairs_[p];
      columns(static_cast<Index>(p), EllipticContact::parameters - 1) =
          volts_[p] / 2 * (m.impedance(a, b) + m.impedance(b, a));
    }
    along.noalias() = differentiation_[static_cast<std::size_t>(border.count)].lazyProduct(u);
    const double step = 2 * pi / border.count;
    m.gains.resize(static_cast<std::size_t>(border.count) * strains);
    for (int i = 0; i < border.count; ++i) {
      const auto p = first + static_cast<std::size_t>(i);
      const double length = std::sqrt(std::norm(m.tangent[p]));
      along.row(i) *= step / length;  // du/dt on the sheet
      // The current density; its gain is 1 / ratio of that along the border.
      q.row(i) *= 1 / (length * std::sqrt(border.ratio));
      const Complex normal(m.tangent[p].imag(), -m.tangent[p].real());
      for (int strain = 0; strain < strains; ++strain) {
        m.gains[static_cast<std::size_t>(i * strains + strain)] =
            (border.ratio - 1) * (std::conj(normal) * shift_by(strain, m.from_centre[p])).real();
      }
    }
    sum_products(along.data(), q.data(), m.gains.data(), border.count, stride_, m.products.data());
    Eigen::Matrix<double, strains, EllipticContact::parameters - 1> to_parameters;
    to_parameters.setIdentity();
    to_parameters.bottomRightCorner<2, 2>() =
        motion_of(m.contacts[k]).block<2, 2>(ContactMotion::stretch, 3);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto [least, most] = std::minmax(pairs_[p][0], pairs_[p][1]);
      Eigen::Matrix<double, 1, strains> by_strain;
      for (int strain = 0; strain < strains; ++strain) {
        by_strain[strain] =
            volts_[p] *
            m.products[static_cast<std::size_t>((strain * stride_ + least) * stride_ + most)];
      }
      columns.row(static_cast<Index>(p)).head<strains>() = by_strain * to_parameters;
    }
  }
}

}  // namespace ertbench
