#include "solvers/total_variation/gram.h"

#include <algorithm>
#include <array>

namespace ertbench {
namespace {

constexpr Eigen::Index gram_lanes = 8;
constexpr Eigen::Index rows_at_once = 64;  ///< of G, which stay in the first-level cache
using GramLanes = Eigen::Array<double, gram_lanes, 1>;

/// Eight columns of the sum from `sum`, `registers` times eight rows of it, in registers all the
/// while. `left` and `right` point into the first of `rows` rows of G.
template <int registers>
void add_tile(const double* left, const double* right, Eigen::Index stride, Eigen::Index rows,
              double* sum, Eigen::Index sum_stride) {
  std::array<std::array<GramLanes, registers>, gram_lanes> tile;
  for (std::size_t a = 0; a < gram_lanes; ++a) {
    for (std::size_t b = 0; b < registers; ++b) tile[a][b].setZero();
  }
  for (Eigen::Index k = 0; k < rows; ++k, left += stride, right += stride) {
    std::array<GramLanes, registers> row;
    for (std::size_t b = 0; b < registers; ++b) {
      row[b] = Eigen::Map<const GramLanes>(right + b * gram_lanes);
    }
    for (std::size_t a = 0; a < gram_lanes; ++a) {
      for (std::size_t b = 0; b < registers; ++b) tile[a][b] += left[a] * row[b];
    }
  }
  for (std::size_t a = 0; a < gram_lanes; ++a, sum += sum_stride) {
    for (std::size_t b = 0; b < registers; ++b) {
      Eigen::Map<GramLanes>(sum + b * gram_lanes) += tile[a][b];
    }
  }
}

}  // namespace

void add_gram(const RowMajorMatrix& tall, Eigen::Index rows, Eigen::MatrixXd& sum) {
  const Eigen::Index stride = tall.cols();
  for (Eigen::Index first = 0; first < rows; first += rows_at_once) {
    const Eigen::Index size = std::min(rows_at_once, rows - first);
    const double* const g = tall.data() + first * stride;
    for (Eigen::Index a = 0; a < sum.cols(); a += gram_lanes) {
      Eigen::Index b = a;
      const auto tile = [&](auto add, Eigen::Index width) {
        add(g + a, g + b, stride, size, &sum(b, a), sum.rows());
        b += width;
      };
      while (sum.rows() - b >= 3 * gram_lanes) tile(add_tile<3>, 3 * gram_lanes);
      if (sum.rows() - b == 2 * gram_lanes) tile(add_tile<2>, 2 * gram_lanes);
      if (sum.rows() - b == gram_lanes) tile(add_tile<1>, gram_lanes);
    }
  }
}

}  // namespace ertbench
