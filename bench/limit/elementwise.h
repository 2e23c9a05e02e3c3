#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ertbench {

// One value after the other: of Eigen's own vectorised functions GCC 12 says that they read what
// was never written.

template <typename Values>
Eigen::ArrayXd exp_of(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::exp(x); });
}

template <typename Values>
double sum_of_logs(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::log(x); }).sum();
}

}  // namespace ertbench
