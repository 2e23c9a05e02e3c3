#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

namespace ertbench {

/// Pairs (row, column) of `distance` [rows, columns], each row and each column in at most one, of
/// which the sum of min(distance, cutoff) is the least there is; as many as rows or columns,
/// whichever are fewer, without those at the cutoff or beyond it. By ascending row. Exact, by the
/// Hungarian method (Kuhn 1955) in O(n^3).
std::vector<std::pair<int, int>> assign(const Eigen::MatrixXd& distance, double cutoff);

}  // namespace ertbench
