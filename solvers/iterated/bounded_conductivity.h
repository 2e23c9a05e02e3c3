#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ertbench {

/// The variable in which conductivities are sought, t in S/m: any t is a conductivity between the
/// bounds, and t is the change from the background itself where that is small, so that a penalty on
/// t means what it means for linear solvers. With s = conductivity / background, low < s < high,
///
///     s = low + (high - low) / (1 + (high - 1) / (1 - low) exp(-a t / background)),
///     a = (high - low) / ((1 - low) (high - 1)),
///
/// a logistic curve through s = 1 at t = 0, where its slope is 1 / background.
class BoundedConductivity {
 public:
  BoundedConductivity() = default;
  /// 0 <= low < 1 < high.
  BoundedConductivity(double background, double low, double high)
      : background_(background),
        low_(low),
        high_(high),
        rate_((high - low) / ((1 - low) * (high - 1)) / background),
        odds_((high - 1) / (1 - low)) {}

  /// s and ds/dt, 1 / (S/m), of every t.
  void ratios(const Eigen::VectorXd& t, Eigen::VectorXd& ratio, Eigen::VectorXd& slope) const {
    ratio = low_ + (high_ - low_) / (1 + odds_ * (-rate_ * t.array()).exp());
    // Rounding must not put a conductivity onto its bound, which may be zero.
    ratio = ratio.array().max(low_ + least).min(high_);
    slope = rate_ / (high_ - low_) * (ratio.array() - low_) * (high_ - ratio.array());
  }

  /// t of conductivities [n] S/m; those outside of the bounds are drawn in.
  template <typename Derived>
  auto variable(const Eigen::ArrayBase<Derived>& conductivity) const {
    constexpr double inside = 1e-3;
    return ((conductivity / background_)
                .max(low_ + inside * (1 - low_))
                .min(high_ - inside * (high_ - 1)))
        .unaryExpr([low = low_, high = high_, rate = rate_, odds = odds_](double s) {
          return -std::log((high - s) / (s - low) / odds) / rate;
        });
  }

 private:
  static constexpr double least = 1e-9;

  double background_ = 1;
  double low_ = 0;
  double high_ = 2;
  double rate_ = 2;
  double odds_ = 1;
};

}  // namespace ertbench
