#include "forward/fem/contact_update.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace ertbench {
namespace {

/// Conductivity ratios of the pixels around a node, 0 outside the sheet: lower left, lower right,
/// upper left, upper right.
std::array<double, 4> pixels_around(const double* ratio, int columns, int rows, int row,
                                    int column) {
  const auto at = [&](int r, int c) {
    return r < 0 || c < 0 || r >= rows || c >= columns ? 0.0 : ratio[c + columns * r];
  };
  return {at(row - 1, column - 1), at(row - 1, column), at(row, column - 1), at(row, column)};
}

}  // namespace

ContactUpdate::ContactUpdate(int columns, int rows, std::vector<int> electrodes,
                             std::vector<ElectrodePair> pairs)
    : columns_(columns),
      rows_(rows),
      electrodes_(std::move(electrodes)),
      pairs_(std::move(pairs)),
      is_electrode_(static_cast<std::size_t>((columns + 1) * (rows + 1)), 0),
      green_(columns, rows) {
  const int side = columns + 1;
  const int nodes = side * (rows + 1);
  const auto count = static_cast<Eigen::Index>(electrodes_.size());
  RowMajorMatrix potentials(nodes, count);  // of a unit current into each electrode
  for (Eigen::Index e = 0; e < count; ++e) {
    const int source = electrodes_[static_cast<std::size_t>(e)];
    is_electrode_[static_cast<std::size_t>(source)] = 1;
    for (int node = 0; node < nodes; ++node) {
      potentials(node, e) = green_(node / side, node % side, source / side, source % side);
    }
  }
  fields_.resize(nodes, static_cast<Eigen::Index>(pairs_.size()));
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    fields_.col(static_cast<Eigen::Index>(k)) =
        potentials.col(pairs_[k].second) - potentials.col(pairs_[k].first);
  }
}

std::vector<int> ContactUpdate::active_nodes(const double* ratio) const {
  std::vector<int> active;
  const int side = columns_ + 1;
  for (int row = 0; row <= rows_; ++row) {
    const double* below = ratio + columns_ * std::max(row - 1, 0);
    const double* above = ratio + columns_ * std::min(row, rows_ - 1);
    for (int column = 0; column < side; ++column) {
      const int left = std::max(column - 1, 0);
      const int right = std::min(column, columns_ - 1);
      const double first = below[left];
      const bool uniform = below[right] == first && above[left] == first && above[right] == first;
      const int node = column + side * row;
      if (!uniform || (first != 1 && is_electrode_[static_cast<std::size_t>(node)])) {
        active.push_back(node);
      }
    }
  }
  return active;
}

Eigen::Array4d ContactUpdate::edges(const double* ratio, int node) const {
  const int side = columns_ + 1;
  const auto [lower_left, lower_right, upper_left, upper_right] =
      pixels_around(ratio, columns_, rows_, node / side, node % side);
  return 0.5 * Eigen::Array4d(lower_left + upper_left, lower_right + upper_right,
                              lower_left + lower_right, upper_left + upper_right);
}

Eigen::MatrixXd ContactUpdate::impedance_change(const double* ratio,
                                                const std::vector<int>& active) const {
  const int side = columns_ + 1;
  const auto count = static_cast<Eigen::Index>(active.size());
  const auto drives = static_cast<Eigen::Index>(pairs_.size());

  // The Green's function from every active node to the active nodes and their neighbours, one row
  // a receiving node.
  const std::array<int, 4> step = {-1, 1, -side, side};
  std::vector<int> row_of(is_electrode_.size(), -1);
  std::vector<int> receivers;
  const auto receive = [&](int node) {
    if (row_of[static_cast<std::size_t>(node)] >= 0) return;
    row_of[static_cast<std::size_t>(node)] = static_cast<int>(receivers.size());
    receivers.push_back(node);
  };
  std::vector<Eigen::Array4d> conductances(active.size());
  for (std::size_t i = 0; i < active.size(); ++i) {
    conductances[i] = edges(ratio, active[i]);
    receive(active[i]);
    for (std::size_t e = 0; e < 4; ++e) {
      if (conductances[i][static_cast<Eigen::Index>(e)] > 0) receive(active[i] + step[e]);
    }
  }
  RowMajorMatrix green(static_cast<Eigen::Index>(receivers.size()), count);
  for (std::size_t r = 0; r < receivers.size(); ++r) {
    const int row = receivers[r] / side;
    const int column = receivers[r] % side;
    double* out = green.row(static_cast<Eigen::Index>(r)).data();
    for (std::size_t j = 0; j < active.size(); ++j) {
      out[j] = green_(row, column, active[j] / side, active[j] % side);
    }
  }

  // Rows of K at the active nodes, applied to G and to u0.
  RowMajorMatrix system(count, count);
  RowMajorMatrix currents(count, drives);
  RowMajorMatrix fields(count, drives);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int node = active[static_cast<std::size_t>(i)];
    const Eigen::Array4d& conductance = conductances[static_cast<std::size_t>(i)];
    fields.row(i) = fields_.row(node);
    system.row(i) = conductance.sum() * green.row(row_of[static_cast<std::size_t>(node)]);
    currents.row(i) = -conductance.sum() * fields.row(i);
    for (Eigen::Index e = 0; e < 4; ++e) {
      if (conductance[e] == 0) continue;
      const int neighbour = node + step[static_cast<std::size_t>(e)];
      system.row(i) -= conductance[e] * green.row(row_of[static_cast<std::size_t>(neighbour)]);
      currents.row(i) += conductance[e] * fields_.row(neighbour);
    }
  }
  const auto add_current = [&](int electrode, Eigen::Index pair, double current) {
    const int node = electrodes_[static_cast<std::size_t>(electrode)];
    const auto found = std::lower_bound(active.begin(), active.end(), node);
    if (found != active.end() && *found == node) currents(found - active.begin(), pair) += current;
  };
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    add_current(pairs_[k].first, static_cast<Eigen::Index>(k), -1);
    add_current(pairs_[k].second, static_cast<Eigen::Index>(k), 1);
  }
  return fields.transpose() * system.partialPivLu().solve(currents);
}

}  // namespace ertbench
