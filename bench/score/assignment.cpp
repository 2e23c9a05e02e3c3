#include "bench/score/assignment.h"

#include <algorithm>
#include <limits>

namespace ertbench {
namespace {

constexpr int nobody = -1;

/// The row assigned to each column of `cost` [n, m], n <= m, with the least sum; `nobody` for
/// unassigned columns.
///
/// Adds one row at a time along the shortest alternating path. The potentials keep all reduced
/// costs >= 0, as Dijkstra's algorithm requires.
std::vector<int> rows_of_columns(const Eigen::MatrixXd& cost) {
  const Eigen::Index n = cost.rows();
  const Eigen::Index m = cost.cols();
  // Column m stands for the row that is being added.
  std::vector<int> row_of(static_cast<std::size_t>(m) + 1, nobody);
  std::vector<Eigen::Index> from(static_cast<std::size_t>(m) + 1, m);
  Eigen::VectorXd row_potential = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd column_potential = Eigen::VectorXd::Zero(m + 1);
  for (Eigen::Index first = 0; first < n; ++first) {
    row_of.back() = static_cast<int>(first);
    Eigen::VectorXd shortest =
        Eigen::VectorXd::Constant(m, std::numeric_limits<double>::infinity());
    std::vector<bool> reached(static_cast<std::size_t>(m) + 1, false);
    Eigen::Index column = m;
    while (row_of[static_cast<std::size_t>(column)] != nobody) {
      reached[static_cast<std::size_t>(column)] = true;
      const int row = row_of[static_cast<std::size_t>(column)];
      double step = std::numeric_limits<double>::infinity();
      Eigen::Index next = 0;
      for (Eigen::Index j = 0; j < m; ++j) {
        if (reached[static_cast<std::size_t>(j)]) continue;
        const double length = cost(row, j) - row_potential[row] - column_potential[j];
        if (length < shortest[j]) {
          shortest[j] = length;
          from[static_cast<std::size_t>(j)] = column;
        }
        if (shortest[j] < step) {
          step = shortest[j];
          next = j;
        }
      }
      for (Eigen::Index j = 0; j <= m; ++j) {
        if (reached[static_cast<std::size_t>(j)]) {
          row_potential[row_of[static_cast<std::size_t>(j)]] += step;
          column_potential[j] -= step;
        } else if (j < m) {
          shortest[j] -= step;
        }
      }
      column = next;
    }
    while (column != m) {
      const Eigen::Index before = from[static_cast<std::size_t>(column)];
      row_of[static_cast<std::size_t>(column)] = row_of[static_cast<std::size_t>(before)];
      column = before;
    }
  }
  row_of.pop_back();
  return row_of;
}

}  // namespace

Assignment assign(const Eigen::Ref<const Eigen::MatrixXd>& distances, double cutoff) {
  Assignment out;
  if (distances.size() == 0) return out;
  const bool turned = distances.rows() > distances.cols();
  Eigen::MatrixXd cost =
      distances.unaryExpr([cutoff](double d) { return d < cutoff ? d : cutoff; });
  if (turned) cost.transposeInPlace();
  const std::vector<int> row_of = rows_of_columns(cost);
  std::vector<int> column_of(static_cast<std::size_t>(distances.rows()), nobody);
  for (std::size_t j = 0; j < row_of.size(); ++j) {
    const int i = row_of[j];
    if (i == nobody) continue;
    out.cost += cost(i, static_cast<Eigen::Index>(j));
    if (turned) {
      column_of[j] = i;
    } else {
      column_of[static_cast<std::size_t>(i)] = static_cast<int>(j);
    }
  }
  for (std::size_t i = 0; i < column_of.size(); ++i) {
    const int row = static_cast<int>(i);
    if (column_of[i] == nobody || !(distances(row, column_of[i]) <= cutoff)) continue;
    out.pairs.push_back({row, column_of[i]});
  }
  return out;
}

Eigen::MatrixXd distances_between(std::span<const Eigen::Vector2d> a,
                                  std::span<const Eigen::Vector2d> b) {
  Eigen::MatrixXd out(a.size(), b.size());
  for (Eigen::Index i = 0; i < out.rows(); ++i) {
    for (Eigen::Index j = 0; j < out.cols(); ++j) {
      out(i, j) = (a[static_cast<std::size_t>(i)] - b[static_cast<std::size_t>(j)]).norm();
    }
  }
  return out;
}

double ospa(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double cutoff) {
  const std::size_t fewer = std::min(a.size(), b.size());
  const std::size_t more = std::max(a.size(), b.size());
  if (more == 0) return 0;
  const double alone = cutoff * static_cast<double>(more - fewer);
  return (assign(distances_between(a, b), cutoff).cost + alone) / static_cast<double>(more);
}

}  // namespace ertbench
