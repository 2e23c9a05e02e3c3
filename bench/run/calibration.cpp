#include "bench/run/calibration.h"

#include <Eigen/Core>
#include <chrono>
#include <vector>

#include "core/quantile.h"

namespace ertbench {

double calibration_us() {
  using Clock = std::chrono::steady_clock;
  constexpr int warm_up = 200;
  constexpr int measured = 1001;
  const Eigen::MatrixXd matrix = Eigen::MatrixXd::Constant(576, 104, 1.0 / 104);
  Eigen::VectorXd in = Eigen::VectorXd::Ones(104);
  Eigen::VectorXd out(576);
  std::vector<double> microseconds;
  for (int i = 0; i < warm_up + measured; ++i) {
    const Clock::time_point start = Clock::now();
    out.noalias() = matrix * in;
    in[i % 104] = out[i % 576];  // the next product waits for this one
    const std::chrono::duration<double, std::micro> time = Clock::now() - start;
    if (i >= warm_up) microseconds.push_back(time.count());
  }
  return median(microseconds);
}

}  // namespace ertbench
