#include "forward/fem/forward_model.h"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <numbers>

#include "core/errors.h"
#include "forward/fem/condensation.h"

namespace ertbench {

LatticeGreen::LatticeGreen(int columns, int rows) {
  const int turns = 2 * rows;      // period in the direction of the sum
  const int period = 2 * columns;  // period in the other direction
  // g(a, b) = 1/turns * sum_p cos(2 pi p a / turns) h_p(b), with h_p the periodic solution of
  // (lambda_p - second difference) h = delta; lambda_p = 2 - 2 cos(2 pi p / turns) = 2 cosh t - 2.
  Eigen::MatrixXd cosines(turns + 1, turns);
  Eigen::MatrixXd profiles(turns, period + 1);
  for (int p = 0; p < turns; ++p) {
    const double half_angle = std::numbers::pi * p / turns;
    for (int a = 0; a <= turns; ++a) {
      // The product p * a is reduced first so that the cosine's argument stays small.
      cosines(a, p) = std::cos(2 * std::numbers::pi * ((p * a) % turns) / turns) / turns;
    }
    const double t = 2 * std::asinh(std::sin(half_angle));
    for (int b = 0; b <= period; ++b) {
      if (p == 0) {  // no decay: fixed by a zero mean
        profiles(p, b) = b * (b - double(period)) / (2.0 * period) +
                         (double(period) * period - 1) / (12.0 * period);
      } else {
        // cosh((period/2 - b) t) / (2 sinh t sinh(period/2 t)), written so as not to overflow
        profiles(p, b) = (std::exp(-b * t) + std::exp(-(period - b) * t)) /
                         (2 * std::sinh(t) * -std::expm1(-period * t));
      }
    }
  }
  table_.noalias() = cosines * profiles;
}

namespace {

/// Number of active nodes beyond which condensation is cheaper.
/// bench/benchmarks/forward_benchmark.cpp
/// (`disc`) finds both equal at 38, 95, 230 and 510 nodes on the grids 24, 48, 96 and 192.
std::size_t most_active_nodes(int grid) {
  return static_cast<std::size_t>(0.65 * std::pow(grid, 1.28));
}

}  // namespace

struct ForwardModel::Parts {
  Sensor sensor;
  int grid;
  int columns;
  int rows;
  SensorPairs pairs;
  std::vector<int> electrodes;
  ContactUpdate update;
  Condensation condensation;
  Eigen::VectorXd reference;

  /// Throws InputError unless pixels are square and electrodes are nodes.
  static const Sensor& require_grid(const Sensor& s, int grid) {
    const Eigen::Vector2d pixel = s.sheet->pixels(grid).pixel();
    if (!s.sheet->fills_bounds() || std::abs(pixel.x() - pixel.y()) > 1e-12 * pixel.x()) {
      throw InputError(
          "sensor: the grid model needs a square or a rectangle in square pixels, not a " +
          s.sheet->name() + (s.sheet->fills_bounds() ? " in other pixels" : "") +
          R"(; use "grid": "auto")");
    }
    if (s.electrode_model != ElectrodeModel::point) {
      throw InputError(
          R"(sensor: the grid model needs point electrodes; use "grid": "auto" for wide ones)");
    }
    return s;
  }

  Parts(const Sensor& s, int n)
      : sensor(require_grid(s, n)),
        grid(n),
        columns(s.sheet->image_columns(n)),
        rows(s.sheet->image_rows(n)),
        pairs(s),
        electrodes(electrode_nodes(s, n)),
        update(columns, rows, electrodes, pairs.pairs),
        condensation(columns, rows, electrodes) {
    reference = voltages(drive_impedance_of_background());
  }

  /// Ohm's law at conductivity 1 to volts: V(d, m) = -I/c0 P_m^T K^+ P_d.
  Eigen::VectorXd voltages(const Eigen::MatrixXd& impedance) const {
    Eigen::VectorXd out(static_cast<Eigen::Index>(pairs.channels.size()));
    for (std::size_t c = 0; c < pairs.channels.size(); ++c) {
      const auto& [measurement, drive] = pairs.channels[c];
      out[static_cast<Eigen::Index>(c)] =
          -pairs.currents[c] / sensor.background * impedance(measurement, drive);
    }
    return out;
  }

  Eigen::MatrixXd drive_impedance_of_background() const {
    const RowMajorMatrix& fields = update.background_fields();
    Eigen::MatrixXd at_electrodes(static_cast<Eigen::Index>(electrodes.size()), fields.cols());
    for (std::size_t e = 0; e < electrodes.size(); ++e) {
      at_electrodes.row(static_cast<Eigen::Index>(e)) = fields.row(electrodes[e]);
    }
    return pair_differences(at_electrodes);
  }

  /// Converts rows by electrode to rows by pair: second less first.
  Eigen::MatrixXd pair_differences(const Eigen::MatrixXd& at_electrodes) const {
    Eigen::MatrixXd out(static_cast<Eigen::Index>(pairs.pairs.size()), at_electrodes.cols());
    for (std::size_t k = 0; k < pairs.pairs.size(); ++k) {
      out.row(static_cast<Eigen::Index>(k)) =
          at_electrodes.row(pairs.pairs[k].second) - at_electrodes.row(pairs.pairs[k].first);
    }
    return out;
  }

  RowMajorMatrix fields_of(const Eigen::VectorXd& ratio) const;
  RowMajorMatrix jacobian_from(const RowMajorMatrix& fields) const;
};

ForwardModel::ForwardModel(const Sensor& sensor, int grid)
    : parts_(std::make_unique<Parts>(sensor, grid)) {}
ForwardModel::~ForwardModel() = default;
ForwardModel::ForwardModel(ForwardModel&&) noexcept = default;

const Sensor& ForwardModel::sensor() const { return parts_->sensor; }
int ForwardModel::grid() const { return parts_->grid; }
const Eigen::VectorXd& ForwardModel::reference_voltages() const { return parts_->reference; }

Frames ForwardModel::solve(const Eigen::Ref<const Images>& conductivity,
                           ForwardMethod method) const {
  const Parts& parts = *parts_;
  constexpr int lanes = Condensation::lanes;
  const Images ratio = conductivity / parts.sensor.background;
  Frames voltages(conductivity.rows(), parts.sensor.channels());

  std::vector<Eigen::Index> to_condense;
  const auto nodes = static_cast<std::size_t>((parts.columns + 1) * (parts.rows + 1));
  for (Eigen::Index s = 0; s < ratio.rows(); ++s) {
    bool condense = method == ForwardMethod::condensation;
    if (!condense) {
      const std::vector<int> active = parts.update.active_nodes(ratio.row(s).data());
      const std::size_t limit =
          method == ForwardMethod::automatic ? most_active_nodes(parts.grid) : nodes - 1;
      condense = active.size() > limit;
      if (!condense) {
        const Eigen::MatrixXd change = parts.update.impedance_change(ratio.row(s).data(), active);
        voltages.row(s) = parts.reference + parts.voltages(change);
      }
    }
    if (condense) to_condense.push_back(s);
  }

  if (to_condense.empty()) return voltages;
  Condensation::Workspace workspace(parts.condensation);
  std::array<Eigen::MatrixXd, lanes> impedance;
  for (std::size_t first = 0; first < to_condense.size(); first += lanes) {
    std::array<const double*, lanes> sheets{};
    const std::size_t count = std::min<std::size_t>(lanes, to_condense.size() - first);
    for (std::size_t lane = 0; lane < count; ++lane) {
      sheets[lane] = ratio.row(to_condense[first + lane]).data();
    }
    parts.condensation.solve(sheets, impedance, workspace);
    for (std::size_t lane = 0; lane < count; ++lane) {
      const Eigen::MatrixXd drives =
          parts.pair_differences(parts.pair_differences(impedance[lane]).transpose());
      voltages.row(to_condense[first + lane]) = parts.voltages(drives);
    }
  }
  return voltages;
}

/// Potentials [nodes, pairs] of the sheet of conductivity `ratio` under unit currents of pairs.
RowMajorMatrix ForwardModel::Parts::fields_of(const Eigen::VectorXd& ratio) const {
  const int side = columns + 1;
  const int nodes = side * (rows + 1);
  std::vector<Eigen::Triplet<double>> entries;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const double half = 0.5 * ratio[column + columns * row];
      const int corner = column + side * row;
      const std::array<int, 4> corners = {corner, corner + 1, corner + side + 1, corner + side};
      for (std::size_t c = 0; c < 4; ++c) {
        const int a = corners[c];
        const int b = corners[(c + 1) % 4];
        entries.emplace_back(a, a, 2 * half);
        entries.emplace_back(std::max(a, b), std::min(a, b), -half);
      }
    }
  }
  const int grounded = electrodes.back();
  entries.emplace_back(grounded, grounded, 1.0);  // fixes the constant; no current flows there
  Eigen::SparseMatrix<double> stiffness(nodes, nodes);
  stiffness.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(stiffness);

  Eigen::MatrixXd currents =
      Eigen::MatrixXd::Zero(nodes, static_cast<Eigen::Index>(pairs.pairs.size()));
  for (std::size_t k = 0; k < pairs.pairs.size(); ++k) {
    const auto pair = static_cast<Eigen::Index>(k);
    currents(electrodes[static_cast<std::size_t>(pairs.pairs[k].first)], pair) -= 1;
    currents(electrodes[static_cast<std::size_t>(pairs.pairs[k].second)], pair) += 1;
  }
  return factor.solve(currents);
}

/// dV(d, m)/dsigma_p = +I int_p grad u_d . grad u_m: half the sum over the pixel's four edges of
/// the products of the differences along them.
RowMajorMatrix ForwardModel::Parts::jacobian_from(const RowMajorMatrix& fields) const {
  const int side = columns + 1;
  const double scale = 0.5 / (sensor.background * sensor.background);
  RowMajorMatrix jacobian(static_cast<Eigen::Index>(pairs.channels.size()), columns * rows);
  const auto count = static_cast<Eigen::Index>(pairs.pairs.size());
  RowMajorMatrix differences(4, count);
  RowMajorMatrix products(count, count);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int corner = column + side * row;
      differences.row(0) = fields.row(corner + 1) - fields.row(corner);
      differences.row(1) = fields.row(corner + side + 1) - fields.row(corner + side);
      differences.row(2) = fields.row(corner + side) - fields.row(corner);
      differences.row(3) = fields.row(corner + side + 1) - fields.row(corner + 1);
      products.noalias() = scale * differences.transpose() * differences;
      for (std::size_t c = 0; c < pairs.channels.size(); ++c) {
        jacobian(static_cast<Eigen::Index>(c), column + columns * row) =
            pairs.currents[c] * products(pairs.channels[c][0], pairs.channels[c][1]);
      }
    }
  }
  return jacobian;
}

RowMajorMatrix ForwardModel::jacobian() const {
  return parts_->jacobian_from(parts_->update.background_fields());
}

RowMajorMatrix ForwardModel::jacobian(const Eigen::VectorXd& conductivity) const {
  return parts_->jacobian_from(parts_->fields_of(conductivity / parts_->sensor.background));
}

}  // namespace ertbench
