#include "solvers/linear/singular_triplets.h"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace ertbench {
namespace {

constexpr double rank_tolerance = 1e-13;

/// x -> [0 D; D^T 0] x with D = C - left diag(values) right^T, what is left of C.
class DeflatedOperator {
 public:
  using Scalar = double;

  DeflatedOperator(const Eigen::MatrixXd& c, const SingularTriplets& found)
      : rest_(c - found.left * found.values.asDiagonal() * found.right.transpose()) {}
  Eigen::Index rows() const { return 2 * rest_.rows(); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* in, double* out) const {
    const Eigen::Index n = rest_.rows();
    Eigen::Map<Eigen::VectorXd>(out, n).noalias() =
        rest_ * Eigen::Map<const Eigen::VectorXd>(in + n, n);
    Eigen::Map<Eigen::VectorXd>(out + n, n).noalias() =
        rest_.transpose() * Eigen::Map<const Eigen::VectorXd>(in, n);
  }

 private:
  Eigen::MatrixXd rest_;
};

/// Removes from `vector` what lies in the span of the columns of `basis`.
void orthogonalise(const Eigen::MatrixXd& basis, Eigen::VectorXd& vector) {
  for (int twice = 0; twice < 2; ++twice) vector -= basis * (basis.transpose() * vector);
}

/// Adds a triplet of c by its vectors; the Rayleigh quotient is its value to rounding.
void append(SingularTriplets& found, const Eigen::MatrixXd& c, Eigen::VectorXd left,
            Eigen::VectorXd right) {
  orthogonalise(found.left, left);
  orthogonalise(found.right, right);
  left.normalize();
  right.normalize();
  const Eigen::Index k = found.values.size();
  found.values.conservativeResize(k + 1);
  found.left.conservativeResize(Eigen::NoChange, k + 1);
  found.right.conservativeResize(Eigen::NoChange, k + 1);
  found.values[k] = left.dot(c * right);
  found.left.col(k) = left;
  found.right.col(k) = right;
}

void sort_and_cut(SingularTriplets& found, Eigen::Index count) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(found.values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index i, Eigen::Index j) {
    return found.values[i] > found.values[j];
  });
  order.resize(static_cast<std::size_t>(std::min(count, found.values.size())));
  found = SingularTriplets{found.values(order), found.left(Eigen::all, order),
                           found.right(Eigen::all, order)};
}

void check_residuals(const Eigen::MatrixXd& c, const SingularTriplets& found) {
  const auto s = found.values.asDiagonal();
  const double error =
      std::max((c * found.right - found.left * s).colwise().norm().maxCoeff(),
               (c.transpose() * found.left - found.right * s).colwise().norm().maxCoeff());
  if (!(error <= 1e-12 * found.values[0])) {
    throw std::runtime_error("the singular value decomposition did not converge");
  }
}

SingularTriplets triplets_of_square(const Eigen::MatrixXd& c, Eigen::Index count) {
  const Eigen::Index n = c.rows();
  SingularTriplets found{Eigen::VectorXd(0), Eigen::MatrixXd(n, 0), Eigen::MatrixXd(n, 0)};
  while (found.values.size() < n) {
    // At first all that are wanted; from then on a few, to see whether a larger one was missed.
    const bool enough = found.values.size() >= count;
    const Eigen::Index wanted =
        std::min(2 * n - 1, enough ? 4 : std::max<Eigen::Index>(4, count - found.values.size()));
    const Eigen::Index space = std::min(2 * n, std::max<Eigen::Index>(2 * wanted + 1, 40));
    DeflatedOperator op(c, found);
    Spectra::SymEigsSolver<DeflatedOperator> solver(op, wanted, space);
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-14);
    const Eigen::VectorXd values = solver.eigenvalues();
    const Eigen::MatrixXd vectors = solver.eigenvectors();

    double largest = found.values.size() ? found.values.maxCoeff() : 0;
    if (values.size()) largest = std::max(largest, values.maxCoeff());
    const double floor = enough ? found.values[count - 1] : rank_tolerance * largest;
    bool more = false;
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      if (values[i] <= floor * (1 + 1e-12) || values[i] <= rank_tolerance * largest) continue;
      append(found, c, vectors.col(i).head(n), vectors.col(i).tail(n));
      more = true;
    }
    sort_and_cut(found, n);
    if (!more) break;
  }
  sort_and_cut(found, count);
  return found;
}

/// 1 for 0, which has none near.
double power_of_two_near(double value) {
  return value > 0 && std::isfinite(value) ? std::exp2(std::ilogb(value)) : 1.0;
}

}  // namespace

SingularTriplets leading_singular_triplets(const Eigen::MatrixXd& a, Eigen::Index count) {
  if (a.rows() > a.cols()) {
    SingularTriplets found = leading_singular_triplets(a.transpose(), count);
    std::swap(found.left, found.right);
    return found;
  }
  const Eigen::Index n = a.rows();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a.transpose());
  Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  // The iteration takes numbers below 1e-20 or so for none; a power of two rounds nothing.
  const double scale = power_of_two_near(r.cwiseAbs().maxCoeff());
  r /= scale;
  SingularTriplets found = triplets_of_square(r.transpose(), std::min(count, n));
  check_residuals(r.transpose(), found);
  found.values *= scale;
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(a.cols(), found.right.cols());
  padded.topRows(n) = found.right;
  found.right = qr.householderQ() * padded;
  return found;
}

}  // namespace ertbench
