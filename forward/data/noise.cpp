#include "forward/data/noise.h"

namespace ertbench {

void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame) {
  if (!noise.snr_db) return;
  Eigen::VectorXd direction(frame.size());
  for (double& value : direction) value = random.normal();
  frame += direction * (noise_norm(noise, reference, frame) / direction.norm());
}

double noise_norm(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
                  const Eigen::Ref<const Eigen::VectorXd>& frame) {
  constexpr double without_noise_db = 80;
  if (!noise.snr_db) return frame.norm() * std::pow(10.0, -without_noise_db / 20);
  const double signal =
      noise.basis == SnrBasis::absolute ? frame.norm() : (frame - reference).norm();
  return signal * std::pow(10.0, -*noise.snr_db / 20);
}

const char* name_of(SnrBasis basis) {
  return basis == SnrBasis::absolute ? "absolute" : "difference";
}

}  // namespace ertbench
