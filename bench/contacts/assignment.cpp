#include "bench/contacts/assignment.h"

#include <algorithm>
#include <limits>

namespace ertbench {
namespace {

/// The column of each row of `cost` [rows, columns], rows <= columns, by shortest augmenting paths:
/// rows join one by one, and the potentials of rows and columns keep every reduced cost >= 0.
std::vector<int> column_of_each_row(const Eigen::MatrixXd& cost) {
  const int rows = static_cast<int>(cost.rows());
  const int columns = static_cast<int>(cost.cols());
  constexpr int nobody = -1;
  std::vector<double> row_potential(static_cast<std::size_t>(rows), 0);
  std::vector<double> column_potential(static_cast<std::size_t>(columns) + 1, 0);
  // The last column is the one that the joining row holds while its path is sought.
  std::vector<int> row_of(static_cast<std::size_t>(columns) + 1, nobody);
  for (int joining = 0; joining < rows; ++joining) {
    std::vector<double> slack(static_cast<std::size_t>(columns),
                              std::numeric_limits<double>::infinity());
    std::vector<int> before(static_cast<std::size_t>(columns), columns);
    std::vector<bool> visited(static_cast<std::size_t>(columns) + 1, false);
    int column = columns;
    row_of[static_cast<std::size_t>(column)] = joining;
    while (row_of[static_cast<std::size_t>(column)] != nobody) {
      visited[static_cast<std::size_t>(column)] = true;
      const int row = row_of[static_cast<std::size_t>(column)];
      int nearest = nobody;
      for (int c = 0; c < columns; ++c) {
        const auto i = static_cast<std::size_t>(c);
        if (visited[i]) continue;
        const double reduced =
            cost(row, c) - row_potential[static_cast<std::size_t>(row)] - column_potential[i];
        if (reduced < slack[i]) {
          slack[i] = reduced;
          before[i] = column;
        }
        if (nearest == nobody || slack[i] < slack[static_cast<std::size_t>(nearest)]) nearest = c;
      }
      const double step = slack[static_cast<std::size_t>(nearest)];
      for (std::size_t i = 0; i < visited.size(); ++i) {
        if (visited[i]) {
          row_potential[static_cast<std::size_t>(row_of[i])] += step;
          column_potential[i] -= step;
        } else if (i < slack.size()) {
          slack[i] -= step;
        }
      }
      column = nearest;
    }
    while (column != columns) {  // along the path every column takes the row of the one before
      const int previous = before[static_cast<std::size_t>(column)];
      row_of[static_cast<std::size_t>(column)] = row_of[static_cast<std::size_t>(previous)];
      column = previous;
    }
  }
  std::vector<int> out(static_cast<std::size_t>(rows));
  for (int c = 0; c < columns; ++c) {
    const int row = row_of[static_cast<std::size_t>(c)];
    if (row != nobody) out[static_cast<std::size_t>(row)] = c;
  }
  return out;
}

}  // namespace

std::vector<std::pair<int, int>> assign(const Eigen::MatrixXd& distance, double cutoff) {
  std::vector<std::pair<int, int>> pairs;
  if (distance.size() == 0) return pairs;
  const bool wide = distance.rows() <= distance.cols();
  const Eigen::MatrixXd cost =
      wide ? Eigen::MatrixXd(distance.cwiseMin(cutoff)) : distance.transpose().cwiseMin(cutoff);
  const std::vector<int> columns = column_of_each_row(cost);
  for (int row = 0; row < static_cast<int>(columns.size()); ++row) {
    const int column = columns[static_cast<std::size_t>(row)];
    if (cost(row, column) >= cutoff) continue;
    pairs.emplace_back(wide ? row : column, wide ? column : row);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace ertbench
