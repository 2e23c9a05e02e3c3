#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ertbench {

/// LU factorisation of a small row-major square matrix with row-major right-hand sides. It only
/// adds multiples of rows to rows, and reuses its memory from one matrix to the next.
///
/// Without pivoting, for diagonally dominant matrices. EllipseModel's has 1 / (2 mu), at least 1/2
/// in size, on the diagonal, and the interaction of borders beside it.
class RowLu {
 public:
  static constexpr int lanes = 8;  ///< doubles of a vector: rows begin at multiples of it

  /// Makes room for a matrix [size, size]; its contents are undefined.
  void resize(int size) {
    size_ = size;
    stride_ = (size + lanes - 1) / lanes * lanes;
    const std::size_t square = static_cast<std::size_t>(size) * static_cast<std::size_t>(stride_);
    if (numbers_.size() < square) numbers_.resize(square);
    if (inverse_.size() < at(size)) inverse_.resize(at(size));
  }

  double* row(int i) { return &numbers_[offset(i)]; }
  const double* row(int i) const { return &numbers_[offset(i)]; }

  /// Replaces the matrix by its factors. Each row adds the rows above it four at a time, so that it
  /// is read and written a quarter as often.
  void factor() {
    for (int i = 0; i < size_; ++i) {
      double* target = row(i);
      int k = 0;
      for (; k + 4 <= i; k += 4) {
        const double* p0 = row(k);
        const double* p1 = row(k + 1);
        const double* p2 = row(k + 2);
        const double* p3 = row(k + 3);
        const double s0 = target[k] * inverse_[at(k)];
        const double s1 = (target[k + 1] - s0 * p0[k + 1]) * inverse_[at(k + 1)];
        const double s2 = (target[k + 2] - s0 * p0[k + 2] - s1 * p1[k + 2]) * inverse_[at(k + 2)];
        const double s3 = (target[k + 3] - s0 * p0[k + 3] - s1 * p1[k + 3] - s2 * p2[k + 3]) *
                          inverse_[at(k + 3)];
        for (int j = k + 4; j < size_; ++j) {
          target[j] -= s0 * p0[j] + s1 * p1[j] + s2 * p2[j] + s3 * p3[j];
        }
        target[k] = s0;
        target[k + 1] = s1;
        target[k + 2] = s2;
        target[k + 3] = s3;
      }
      for (; k < i; ++k) {
        const double* pivot = row(k);
        const double share = target[k] * inverse_[at(k)];
        target[k] = share;
        for (int j = k + 1; j < size_; ++j) target[j] -= share * pivot[j];
      }
      inverse_[at(i)] = 1 / target[i];
    }
  }

  /// Solves in place for `sides` [size, width]; `width` is a multiple of `lanes`.
  void solve(std::vector<double>& sides, int width) const {
    for (int c = 0; c < width; c += lanes) {
      for (int i = 1; i < size_; ++i)
        side(sides, width, i, c) -= sum(row(i), 1, sides, width, 0, i, c);
      for (int i = size_ - 1; i >= 0; --i) {
        const Lanes known = sum(row(i) + i + 1, 1, sides, width, i + 1, size_, c);
        side(sides, width, i, c) = (side(sides, width, i, c) - known) * inverse_[at(i)];
      }
    }
  }
  /// As above for the transposed matrix.
  void solve_transposed(std::vector<double>& sides, int width) const {
    for (int c = 0; c < width; c += lanes) {
      for (int i = 0; i < size_; ++i) {
        const Lanes known = sum(row(0) + i, stride_, sides, width, 0, i, c);
        side(sides, width, i, c) = (side(sides, width, i, c) - known) * inverse_[at(i)];
      }
      for (int i = size_ - 2; i >= 0; --i) {
        side(sides, width, i, c) -= sum(row(i + 1) + i, stride_, sides, width, i + 1, size_, c);
      }
    }
  }

 private:
  using Lanes = Eigen::Array<double, lanes, 1>;

  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  std::size_t offset(int i) const { return at(i) * at(stride_); }
  static Eigen::Map<Lanes> side(std::vector<double>& sides, int width, int i, int column) {
    return Eigen::Map<Lanes>(&sides[at(i) * at(width) + at(column)]);
  }
  /// Sum over rows `from` ... `to` of `lanes` columns of the sides, times factors `step` apart.
  /// Four independent partial sums hide the latency of additions.
  static Lanes sum(const double* factors, int step, const std::vector<double>& sides, int width,
                   int from, int to, int column) {
    const double* rows = sides.data() + at(from) * at(width) + at(column);
    const auto term = [&](int i) {
      return factors[at(i) * at(step)] * Eigen::Map<const Lanes>(rows + at(i) * at(width));
    };
    Lanes sum0 = Lanes::Zero();
    Lanes sum1 = sum0;
    Lanes sum2 = sum0;
    Lanes sum3 = sum0;
    const int count = to - from;
    int i = 0;
    for (; i + 4 <= count; i += 4) {
      sum0 += term(i);
      sum1 += term(i + 1);
      sum2 += term(i + 2);
      sum3 += term(i + 3);
    }
    for (; i < count; ++i) sum0 += term(i);
    return (sum0 + sum1) + (sum2 + sum3);
  }

  int size_ = 0;
  int stride_ = 0;
  std::vector<double> numbers_;
  std::vector<double> inverse_;  ///< of the pivots
};

}  // namespace ertbench
