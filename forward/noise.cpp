#include "forward/noise.h"

namespace ertbench {

void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame) {
  if (!noise.snr_db) return;
  Eigen::VectorXd direction(frame.size());
  for (double& value : direction) value = random.normal();
  const double signal =
      noise.basis == SnrBasis::absolute ? frame.norm() : (frame - reference).norm();
  frame += direction * (signal * std::pow(10.0, -*noise.snr_db / 20) / direction.norm());
}

const char* name_of(SnrBasis basis) {
  return basis == SnrBasis::absolute ? "absolute" : "difference";
}

}  // namespace ertbench
