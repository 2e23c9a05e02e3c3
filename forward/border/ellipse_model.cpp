#include "forward/border/ellipse_model.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "forward/border/differentiation.h"
#include "forward/border/gathering.h"
#include "forward/border/row_lu.h"

namespace ertbench {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using std::numbers::pi;

constexpr int least_points = 8;
/// Of the spacing of points over the distance to what is next to them at resolution 1 (see
/// border_layout).
constexpr double spacing_over_distance = 0.8;
constexpr std::size_t most_contacts = 16;
/// Nearer to the sheet's border or to another contact there is no use in going, domain units.
constexpr double closest = 1e-4;
/// Contacts with less contrast than this count with it: 1 / (2 mu) is to stay finite.
constexpr double least_contrast = 1e-9;

}  // namespace

struct EllipseModel::Workspace::Memory {
  struct Border {
    Eigen::Matrix2d to_unit;  ///< of the ellipse onto the unit disc
    double shorter = 0;       ///< half axis
    int first = 0;
    int count = 0;
    double ratio = 1;
  };
  std::vector<Border> borders;
  int points = 0;
  // Of each point: place, normal and weight on the unit disc; the tangent on the sheet times the
  // parameter's step, and where it is from the contact's centre.
  std::vector<double> x, y, normal_x, normal_y, curvature, weight, depth;
  std::vector<Complex> tangent, from_centre;
  RowLu matrix;
  std::vector<double> density;    ///< [points, stride] by drives
  std::vector<double> potential;  ///< [points, stride] of the points' charges, by measuring pairs
  std::vector<double> charges;    ///< [points, stride] the same by electrodes
  std::vector<double> solution;   ///< [points, stride] of the transposed equation
  std::vector<double> along, across, weighted;
  MatrixXd impedance;

  void resize(int count, int stride) {
    points = count;
    matrix.resize(count);
    const auto n = static_cast<std::size_t>(count);
    if (x.size() < n) {
      for (auto* array : {&x, &y, &normal_x, &normal_y, &curvature, &weight, &depth}) {
        array->resize(n);
      }
      tangent.resize(n);
      from_centre.resize(n);
      const std::size_t wide = n * static_cast<std::size_t>(stride);
      for (auto* array : {&density, &potential, &charges, &solution, &along, &across, &weighted}) {
        array->resize(wide);
      }
    }
  }
};

EllipseModel::Workspace::Workspace() : memory_(std::make_unique<Memory>()) {}
EllipseModel::Workspace::~Workspace() = default;
EllipseModel::Workspace::Workspace(Workspace&&) noexcept = default;
EllipseModel::Workspace& EllipseModel::Workspace::operator=(Workspace&&) noexcept = default;
int EllipseModel::Workspace::points() const { return memory_->points; }

EllipseModel::EllipseModel(const Sensor& sensor) : EllipseModel(sensor, Options{}) {}

EllipseModel::EllipseModel(const Sensor& sensor, const Options& options)
    : sensor_(sensor),
      options_(options),
      positions_(electrode_positions(sensor)),
      electrodes_(sensor.electrode_count),
      stride_((sensor.electrode_count + RowLu::lanes - 1) / RowLu::lanes * RowLu::lanes),
      differentiation_(static_cast<std::size_t>(std::max(options.most_points, least_points)) + 1) {
  for (Index e = 0; e < positions_.cols(); ++e) {
    const Complex w = sensor.sheet->to_disc({positions_(0, e), positions_(1, e)}).w;
    x_.push_back(w.real() / std::abs(w));
    y_.push_back(w.imag() / std::abs(w));
  }
  const std::vector<Channel> channels = channels_of(sensor);
  for (const auto& [a, b] : reciprocal_pairs(sensor)) {
    const Channel& channel = channels[static_cast<std::size_t>(a)];
    pairs_.push_back({channel.measurement, channel.drive});
  }
  for (int n = least_points; n <= std::max(options.most_points, least_points); n += 2) {
    differentiation_[static_cast<std::size_t>(n)] = closed_differentiation(n) / (2 * pi);
  }
}

EllipseModel::~EllipseModel() = default;

bool EllipseModel::place_points(std::span<const EllipticContact> contacts,
                                Workspace::Memory& m) const {
  const Sheet& sheet = *sensor_.sheet;
  m.borders.resize(contacts.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const EllipticContact& contact = contacts[k];
    const Eigen::Vector2d axes = contact.half_axes();
    auto& border = m.borders[k];
    border.shorter = axes.y();
    border.to_unit =
        axes.cwiseInverse().asDiagonal() * Eigen::Rotation2Dd(-contact.angle()).toRotationMatrix();
    border.ratio = contact.ratio();
    if (std::abs(1 - border.ratio) < least_contrast) border.ratio = 1 - least_contrast;
    if (!std::isfinite(axes.x()) || !contact.centre.allFinite()) return false;
  }
  std::array<Gathering, most_contacts> gatherings;
  if (contacts.size() > gatherings.size()) return false;
  int total = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const EllipticContact& contact = contacts[k];
    const Eigen::Vector2d axes = contact.half_axes();
    const Complex turn = std::polar(1.0, contact.angle());
    const Complex centre(contact.centre.x(), contact.centre.y());
    std::array<double, gathering_probes>
        demand{};  // points that would do if all the border were as here
    for (std::size_t i = 0; i < gathering_probes; ++i) {
      const double t = 2 * pi * static_cast<double>(i) / gathering_probes;
      const Complex slope = turn * Complex(-axes.x() * std::sin(t), axes.y() * std::cos(t));
      const Complex z = centre + turn * Complex(axes.x() * std::cos(t), axes.y() * std::sin(t));
      const Eigen::Vector2d place(z.real(), z.imag());
      const double depth = sheet.depth(place);
      if (depth < closest) return false;
      // The mirror image in the sheet's border is as far again; an electrode may be as close.
      const double electrode = (positions_.colwise() - place).colwise().squaredNorm().minCoeff();
      double nearest = std::min(2 * depth, std::sqrt(electrode));
      for (std::size_t other = 0; other < contacts.size(); ++other) {
        if (other == k) continue;
        const auto& border = m.borders[other];
        const double level = (border.to_unit * (place - contacts[other].centre)).norm() - 1;
        if (level * border.shorter < closest) return false;
        nearest = std::min(nearest, level * border.shorter);
      }
      demand[i] =
          options_.resolution * 2 * pi * std::abs(slope) / (spacing_over_distance * nearest);
    }
    const double least = options_.resolution * std::max(9.0, 2.1 * axes.x() / axes.y());
    gatherings[k] = gathering_for(demand, least);
    const int even = 2 * static_cast<int>(std::ceil(gatherings[k].count / 2 - 1e-9));
    m.borders[k].first = total;
    m.borders[k].count = std::clamp(even, least_points, options_.most_points / 2 * 2);
    total += m.borders[k].count;
  }
  m.resize(total, stride_);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const EllipticContact& contact = contacts[k];
    const auto& border = m.borders[k];
    const Eigen::Vector2d axes = contact.half_axes();
    const Complex turn = std::polar(1.0, contact.angle());
    const Complex centre(contact.centre.x(), contact.centre.y());
    const double step = 2 * pi / border.count;
    for (int i = 0; i < border.count; ++i) {
      const Gathered g = gathered(step * i, gatherings[k]);
      const double c = std::cos(g.t);
      const double s = std::sin(g.t);
      const Complex offset = turn * Complex(axes.x() * c, axes.y() * s);
      const Complex first = turn * Complex(-axes.x() * s, axes.y() * c);
      const DiscPoint value = sheet.to_disc(centre + offset);
      const double depth = 1 - std::norm(value.w);
      if (depth <= 0) return false;
      const Complex tangent = value.first * first;
      const Complex bend = value.second * first * first - value.first * offset;
      const double speed = std::abs(tangent);
      const auto p = static_cast<std::size_t>(border.first + i);
      m.x[p] = value.w.real();
      m.y[p] = value.w.imag();
      m.normal_x[p] = tangent.imag() / speed;
      m.normal_y[p] = -tangent.real() / speed;
      m.curvature[p] = (std::conj(tangent) * bend).imag() / (speed * speed * speed);
      m.weight[p] = speed * g.slope * step;
      m.depth[p] = depth;
      m.tangent[p] = first * (g.slope * step);
      m.from_centre[p] = offset;
    }
  }
  return true;
}

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
  const auto wide = static_cast<std::size_t>(stride_);
  const auto electrodes = static_cast<std::size_t>(electrodes_);
  for (std::size_t i = 0; i < n; ++i) {
    double* slope = &m.solution[i * wide];  // scratch
    double* charge = &m.charges[i * wide];
    for (std::size_t e = 0; e < electrodes; ++e) {
      const double dx = m.x[i] - x_[e];
      const double dy = m.y[i] - y_[e];
      const double square = dx * dx + dy * dy;
      slope[e] = -1 / pi * (m.normal_x[i] * dx + m.normal_y[i] * dy) / square;
      charge[e] = square;
    }
    for (std::size_t e = 0; e < electrodes; ++e) {
      charge[e] = -0.5 / pi * m.weight[i] * std::log(charge[e]);
    }
    double* drive = &m.density[i * wide];
    double* measured = &m.potential[i * wide];
    for (std::size_t e = 0; e + 1 < electrodes; ++e) {
      drive[e] = slope[e + 1] - slope[e];
      measured[e] = charge[e + 1] - charge[e];
    }
    drive[electrodes - 1] = slope[0] - slope[electrodes - 1];
    measured[electrodes - 1] = charge[0] - charge[electrodes - 1];
    for (std::size_t e = electrodes; e < wide; ++e) drive[e] = measured[e] = 0;
  }
}

bool EllipseModel::are_apart(std::span<const EllipticContact> contacts,
                             Workspace& workspace) const {
  return place_points(contacts, *workspace.memory_);
}

bool EllipseModel::evaluate(std::span<const EllipticContact> contacts, Workspace& workspace,
                            Eigen::Ref<Eigen::VectorXd> change,
                            Eigen::Ref<MatrixXd> derivatives) const {
  Workspace::Memory& m = *workspace.memory_;
  if (!place_points(contacts, m)) return false;
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
  if (derivatives.cols() > 0) differentiate(contacts, m, derivatives);
  return true;
}

void EllipseModel::differentiate(std::span<const EllipticContact> contacts, Workspace::Memory& m,
                                 Eigen::Ref<MatrixXd> derivatives) const {
  const auto wide = static_cast<std::size_t>(stride_);
  std::copy_n(m.potential.begin(), static_cast<std::ptrdiff_t>(wide) * m.points,
              m.solution.begin());
  m.matrix.solve_transposed(m.solution, stride_);
  const double volts = sensor_.drive_current / sensor_.background;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  constexpr int strains = 5;  // x, y, growth, stretch, shear
  Eigen::Matrix<double, Eigen::Dynamic, strains + 1, 0, 2048, strains + 1> columns(pairs(),
                                                                                   strains + 1);
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto& border = m.borders[k];
    const auto first = static_cast<std::size_t>(border.first);
    const double jump = 1 - border.ratio;
    // u = y / (weight (r - l)), and the current l r / (r - l) density; see BorderModel::linearise.
    Eigen::Map<RowMajor> u(&m.solution[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> q(&m.density[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> along(&m.along[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> weighted(&m.weighted[first * wide], border.count, stride_);
    Eigen::Map<RowMajor> weighted_q(&m.across[first * wide], border.count, stride_);
    for (int i = 0; i < border.count; ++i) {
      const auto p = first + static_cast<std::size_t>(i);
      u.row(i) *= 1 / (m.weight[p] * jump);
      // The current through the stretch of border that the point stands for.
      q.row(i) *= border.ratio / jump * m.weight[p];
    }
    const auto take = [&](int column) {
      for (std::size_t p = 0; p < pairs_.size(); ++p) {
        const auto& [a, b] = pairs_[p];
        columns(static_cast<Index>(p), column) =
            volts / 2 * (m.impedance(a, b) + m.impedance(b, a));
      }
    };
    m.impedance.noalias() = u.transpose().lazyProduct(q);
    take(strains);
    along.noalias() = differentiation_[static_cast<std::size_t>(border.count)].lazyProduct(u);
    const double step = 2 * pi / border.count;
    for (int i = 0; i < border.count; ++i) {
      const double length = std::abs(m.tangent[first + static_cast<std::size_t>(i)]);
      along.row(i) *= step / length;  // du/dt on the sheet
      q.row(i) *= 1 / length;         // current density there
    }
    for (int strain = 0; strain < strains; ++strain) {
      for (int i = 0; i < border.count; ++i) {
        const auto p = first + static_cast<std::size_t>(i);
        const Complex offset = m.from_centre[p];
        const Complex shift = strain == 0   ? Complex(1, 0)
                              : strain == 1 ? Complex(0, 1)
                              : strain == 2 ? offset
                              : strain == 3 ? std::conj(offset)
                                            : Complex(0, 1) * std::conj(offset);
        const Complex normal(m.tangent[p].imag(), -m.tangent[p].real());
        const double gain = (border.ratio - 1) * (std::conj(normal) * shift).real();
        weighted.row(i) = gain * along.row(i);
        weighted_q.row(i) = gain / border.ratio * q.row(i);
      }
      m.impedance.noalias() = weighted.transpose().lazyProduct(along);
      m.impedance.noalias() += weighted_q.transpose().lazyProduct(q);
      take(strain);
    }
    const auto motion = motion_of(contacts[k]);
    auto out = derivatives.middleCols(static_cast<Index>(k) * EllipticContact::parameters,
                                      EllipticContact::parameters);
    out.leftCols<3>() = columns.leftCols<3>();
    const Eigen::Matrix2d stretch = motion.block<2, 2>(ContactMotion::stretch, 3);
    out.middleCols<2>(3).noalias() = columns.middleCols<2>(3).lazyProduct(stretch);
    out.col(5) = columns.col(strains);
  }
}

}  // namespace ertbench
