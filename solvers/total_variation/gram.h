#pragma once

#include <Eigen/Core>

#include "core/arrays.h"

namespace ertbench {

/// Adds G^T G, G the first `rows` rows of `tall` [>= rows, columns], to the lower triangle of `sum`
/// [columns, columns]; `columns` is a multiple of 8. Also writes above the diagonal, in the blocks
/// of eight columns that it passes through.
///
/// For matrices of some hundred rows and a hundred columns: nothing is copied, as Eigen's product
/// does, which for these takes as long as a third of the sums.
void add_gram(const RowMajorMatrix& tall, Eigen::Index rows, Eigen::MatrixXd& sum);

}  // namespace ertbench
