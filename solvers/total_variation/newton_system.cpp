#include "solvers/total_variation/newton_system.h"

#include <limits>

#include "solvers/total_variation/gram.h"

namespace ertbench {
namespace {

constexpr int refinements = 4;    ///< at most
constexpr double refined = 1e-8;  ///< relative mismatch between J x and w that is small enough

}  // namespace

NewtonSystem::NewtonSystem(const TotalVariation& problem)
    : problem_(problem),
      band_(problem.edges().columns(), problem.edges().rows()),
      work_(problem.edges().pixels() - 1) {}

bool NewtonSystem::factor(const Eigen::VectorXd& weights, Eigen::Index channels) {
  band_.factor(problem_.edges(), weights);
  half_.resize(band_.unknowns(), channels);
  band_.half_solve(problem_.jacobian_transposed(), channels, half_);
  schur_.setIdentity(channels, channels);
  add_gram(half_, band_.unknowns(), schur_);
  schur_factor_.compute(schur_);
  if (schur_factor_.info() != Eigen::Success) return false;
  constant_ = problem_.constant().head(channels);
  constant_solve_ = schur_factor_.solve(constant_);
  constant_product_ = constant_.dot(constant_solve_);
  return true;
}

void NewtonSystem::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) {
  const Eigen::Index unknowns = band_.unknowns();
  const Eigen::Index channels = half_.cols();
  work_ = right.head(unknowns);
  band_.half_solve(work_);
  data_.noalias() = half_.transpose() * work_;
  double c = solve_data(data_, right.sum());
  work_.noalias() -= half_ * data_;
  band_.half_solve_transposed(work_);
  x.head(unknowns) = work_.array() + c;
  x[unknowns] = c;

  // Where H is small beside J^T J, x is a small difference of large numbers, and J x is not w.
  double before = std::numeric_limits<double>::infinity();
  for (int refinement = 0; refinement < refinements; ++refinement) {
    error_.noalias() = problem_.jacobian_transposed().leftCols(channels).transpose() * x;
    error_ -= data_;
    const double error = error_.norm();
    if (!(error > refined * data_.norm() && error < before / 2)) break;
    before = error;
    c = solve_data(error_, 0);
    data_ += error_;
    work_.noalias() = -half_ * error_;
    band_.half_solve_transposed(work_);
    x.head(unknowns) += (work_.array() + c).matrix();
    x[unknowns] += c;
  }
}

/// w and c of S w - c J 1 = data, (J 1)^T w = sum; w replaces the data.
double NewtonSystem::solve_data(Eigen::VectorXd& data, double sum) const {
  schur_factor_.solveInPlace(data);
  const double c = (sum - constant_.dot(data)) / constant_product_;
  data += c * constant_solve_;
  return c;
}

}  // namespace ertbench
