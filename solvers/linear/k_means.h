#pragma once

#include <Eigen/Core>
#include <vector>

namespace ertbench {

/// Divides the rows of `points` [points, features] into up to `groups` groups of rows that lie
/// close together, by Lloyd's algorithm (k-means) from centres drawn by k-means++, a dozen rounds
/// of it. Each group's rows ascend; none is empty, so that fewer groups come back where points
/// coincide. The same every time.
std::vector<std::vector<Eigen::Index>> k_means(const Eigen::MatrixXf& points, int groups);

}  // namespace ertbench
