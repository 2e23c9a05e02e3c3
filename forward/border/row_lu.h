#pragma once

#include <cstddef>
#include <vector>

namespace ertbench {

/// The factorisation of a small square matrix kept by rows, whose right-hand sides are kept by rows
/// as well: all that it does is adding multiples of rows to rows, and its memory is kept from one
/// matrix to the next.
///
/// Without pivoting, for matrices whose diagonal outweighs the rest: on that of EllipseModel stands
/// 1 / (2 mu), at least 1/2 in size, and beside it what borders do to each other.
class RowLu {
 public:
  static constexpr int lanes = 8;  ///< doubles of a vector: rows begin at multiples of it

  /// Room for a matrix [size, size], of which nothing is kept.
  void resize(int size) {
    size_ = size;
    stride_ = (size + lanes - 1) / lanes * lanes;
    const std::size_t square = static_cast<std::size_t>(size) * static_cast<std::size_t>(stride_);
    if (numbers_.size() < square) numbers_.resize(square);
  }

  double* row(int i) { return &numbers_[offset(i)]; }
  const double* row(int i) const { return &numbers_[offset(i)]; }

  /// In the place of the matrix come its factors.
  void factor() {
    for (int k = 0; k < size_; ++k) {
      const double* pivot = row(k);
      const double inverse = 1 / pivot[k];
      for (int i = k + 1; i < size_; ++i) {
        double* target = row(i);
        const double share = target[k] * inverse;
        target[k] = share;
        for (int j = k + 1; j < size_; ++j) target[j] -= share * pivot[j];
      }
    }
  }

  /// `sides` [size, width] in place: the solution of the equation.
  void solve(std::vector<double>& sides, int width) const {
    const auto side = [&](int i) { return &sides[static_cast<std::size_t>(i) * width]; };
    for (int i = 1; i < size_; ++i) {
      for (int j = 0; j < i; ++j) subtract(row(i)[j], side(j), side(i), width);
    }
    for (int i = size_ - 1; i >= 0; --i) {
      for (int j = i + 1; j < size_; ++j) subtract(row(i)[j], side(j), side(i), width);
      scale(1 / row(i)[i], side(i), width);
    }
  }
  /// The same of the transposed equation.
  void solve_transposed(std::vector<double>& sides, int width) const {
    const auto side = [&](int i) { return &sides[static_cast<std::size_t>(i) * width]; };
    for (int i = 0; i < size_; ++i) {
      scale(1 / row(i)[i], side(i), width);
      for (int j = i + 1; j < size_; ++j) subtract(row(i)[j], side(i), side(j), width);
    }
    for (int i = size_ - 1; i > 0; --i) {
      for (int j = 0; j < i; ++j) subtract(row(i)[j], side(i), side(j), width);
    }
  }

 private:
  std::size_t offset(int i) const {
    return static_cast<std::size_t>(i) * static_cast<std::size_t>(stride_);
  }
  static void subtract(double factor, const double* from, double* to, int width) {
    for (int c = 0; c < width; ++c) to[c] -= factor * from[c];
  }
  static void scale(double factor, double* row, int width) {
    for (int c = 0; c < width; ++c) row[c] *= factor;
  }

  int size_ = 0;
  int stride_ = 0;
  std::vector<double> numbers_;
};

}  // namespace ertbench
