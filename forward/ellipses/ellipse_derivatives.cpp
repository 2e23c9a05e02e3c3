// The derivatives of EllipseModel.

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "forward/ellipses/ellipse_memory.h"

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using std::numbers::pi;

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

void EllipseModel::derivatives(Workspace& workspace, Eigen::Ref<Eigen::MatrixXd> out) const {
  Workspace::Memory& m = *workspace.memory_;
  const auto wide = static_cast<std::size_t>(stride_);
  std::copy_n(m.potential.begin(), static_cast<std::ptrdiff_t>(wide) * m.points,
              m.solution.begin());
  m.matrix.solve_transposed(m.solution, stride_);
  const double volts = sensor_.drive_current / sensor_.background;
  m.products.resize(strains * wide * wide);
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (std::size_t k = 0; k < m.borders.size(); ++k) {
    const auto& border = m.borders[k];
    const auto first = static_cast<std::size_t>(border.first);
    const double jump = 1 - border.ratio;
    // u = y / (weight (r - l)), and the current l r / (r - l) density; see BorderModel::linearise.
    Eigen::Map<RowMajor> u(&m.solution[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> q(&m.density[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> along(&m.along[first * wide], border.count, stride_);
    for (int i = 0; i < border.count; ++i) {
      const auto p = first + static_cast<std::size_t>(i);
      u.row(i) *= 1 / (m.weight[p] * jump);
      // The current through the stretch of border that the point stands for.
      q.row(i) *= border.ratio / jump * m.weight[p];
    }
    auto columns = out.middleCols(static_cast<Index>(k) * EllipticContact::parameters,
                                  EllipticContact::parameters);
    m.impedance.noalias() = u.transpose().lazyProduct(q);
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const auto& [a, b] = pairs_[p];
      columns(static_cast<Index>(p), EllipticContact::parameters - 1) =
          volts / 2 * (m.impedance(a, b) + m.impedance(b, a));
    }
    along.noalias() = differentiation_[static_cast<std::size_t>(border.count)].lazyProduct(u);
    const double step = 2 * pi / border.count;
    m.gains.resize(static_cast<std::size_t>(border.count) * strains);
    for (int i = 0; i < border.count; ++i) {
      const auto p = first + static_cast<std::size_t>(i);
      const double length = std::sqrt(std::norm(m.tangent[p]));
      along.row(i) *= step / length;  // du/dt on the sheet
      // The current density there, by which the gain is 1 / ratio of that along the border.
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
            volts *
            m.products[static_cast<std::size_t>((strain * stride_ + least) * stride_ + most)];
      }
      columns.row(static_cast<Index>(p)).head<strains>() = by_strain * to_parameters;
    }
  }
}

}  // namespace ertbench
