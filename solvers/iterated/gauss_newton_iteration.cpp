#include "solvers/iterated/gauss_newton_iteration.h"

#include <cmath>
#include <utility>

namespace ertbench {
namespace {

constexpr int halvings = 12;
constexpr double sufficient = 1e-4;  ///< part of the promised decrease that a step must bring
/// Promised relative decreases below this are rounding.
constexpr double least_decrease = 1e-13;

}  // namespace

GaussNewtonIteration::GaussNewtonIteration(const Sensor& sensor, const BoundedConductivity& bounds,
                                           std::unique_ptr<Penalty> penalty,
                                           const RowMajorMatrix& background_jacobian)
    : reciprocity_(sensor),
      background_(sensor.background),
      sheet_(sensor),
      bounds_(bounds),
      penalty_(std::move(penalty)),
      background_jacobian_(background_jacobian),
      t_(sensor.pixels()),
      t_trial_(sensor.pixels()) {}

double GaussNewtonIteration::set(const Eigen::VectorXd& z, const std::vector<Eigen::Index>& kept) {
  penalty_->image(z, t_trial_);
  bounds_.ratios(t_trial_, ratio_, slope_);
  sheet_.set_conductivity(ratio_);
  sheet_.changes(kept, modelled_);
  residual_ = data_ - modelled_;
  return residual_.squaredNorm() / 2 + penalty_->value(z);
}

double GaussNewtonIteration::noise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const std::vector<Eigen::Index>& kept) const {
  double square = 0;
  for (const Eigen::Index p : kept) {
    const auto& [a, b] = reciprocity_.pair(p);
    square += (change[a] - change[b]) * (change[a] - change[b]) / 2;
  }
  return std::sqrt(square);
}

void GaussNewtonIteration::minimise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                    const std::vector<Eigen::Index>& kept,
                                    const GaussNewtonOptions& options,
                                    Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report) {
  image.setZero();
  const auto count = static_cast<Eigen::Index>(kept.size());
  data_.resize(count);
  modelled_.setZero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& [a, b] = reciprocity_.pair(kept[static_cast<std::size_t>(i)]);
    data_[i] = reciprocity_.single() ? change[a] : (change[a] + change[b]) / std::sqrt(2.0);
  }
  if (!data_.allFinite()) {
    report.status = FrameStatus::undefined;
    return;
  }
  z_.setZero(penalty_->coordinates());
  t_.setZero();
  bounds_.ratios(t_, ratio_, slope_);
  residual_ = data_;
  objective_ = residual_.squaredNorm() / 2;
  const double done = options.discrepancy > 0 ? options.discrepancy * noise(change, kept) : 0;
  jacobian_.resize(count, t_.size());
  report.iterations = 0;
  while (objective_ > 0 && residual_.norm() > done) {
    report.status = FrameStatus::not_converged;
    if (report.iterations == options.max_iterations) break;
    if (report.iterations == 0) {
      for (Eigen::Index i = 0; i < count; ++i) {
        jacobian_.row(i) = background_jacobian_.row(kept[static_cast<std::size_t>(i)]);
      }
    } else {
      sheet_.jacobian(kept, jacobian_);
    }
    jacobian_.array().rowwise() *= slope_.transpose().array();
    linear_ = residual_;
    linear_.noalias() += jacobian_ * t_;
    if (!penalty_->minimise(jacobian_, linear_, z_, best_)) break;

    // What the linearised problem promises; total variation's quadratic promises no less than the
    // total variation keeps.
    penalty_->image(best_, t_trial_);
    linear_.noalias() -= jacobian_ * t_trial_;
    const double promised = objective_ - linear_.squaredNorm() / 2 - penalty_->value(best_);
    if (!(promised > least_decrease * objective_)) {
      report.status = std::isfinite(promised) ? FrameStatus::ok : FrameStatus::not_converged;
      break;
    }
    double length = 1;
    double reached = 0;
    ratio_before_ = ratio_;
    for (int i = 0;; ++i, length /= 2) {
      trial_ = z_ + length * (best_ - z_);
      reached = set(trial_, kept);
      if (reached <= objective_ - sufficient * length * promised || i == halvings) break;
    }
    if (!(reached < objective_)) break;  // rounding: no step is any better
    ++report.iterations;
    const double before = objective_;
    objective_ = reached;
    std::swap(z_, trial_);
    std::swap(t_, t_trial_);
    // What a step of full length would change, in conductivities: near a bound t runs away.
    const double change_of_image = (ratio_ - ratio_before_).norm() / length;
    if (change_of_image <= options.tolerance * (ratio_.array() - 1).matrix().norm()) {
      report.status = FrameStatus::ok;
      break;
    }
    if (before - reached < least_decrease * before) {
      report.status = FrameStatus::ok;
      break;
    }
    if (residual_.norm() <= done) report.status = FrameStatus::ok;
  }
  bounds_.ratios(t_, ratio_, slope_);
  image = background_ * (ratio_.array() - 1).matrix().transpose();
  if (!image.allFinite()) {
    image.setZero();
    report.status = FrameStatus::undefined;
  }
}

}  // namespace ertbench
