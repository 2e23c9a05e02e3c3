#include "models/training/instance_noise.h"

#include <ATen/CPUGeneratorImpl.h>

#include "core/random.h"

namespace ertbench {

void InstanceNoise::begin_step(std::uint64_t step, std::uint64_t steps) {
  if (largest_ == 0) return;
  const double place = steps > 1 ? static_cast<double>(step) / static_cast<double>(steps - 1) : 0;
  deviation_ = largest_ * (1 - place);
  RandomStream random(seed_, key_of("instance noise"), step, Purpose::training);
  generator_ = at::make_generator<at::CPUGeneratorImpl>(random.bits());
}

torch::Tensor InstanceNoise::add_to(const torch::Tensor& images) {
  if (deviation_ == 0) return images;
  return images + deviation_ * torch::randn(images.sizes(), generator_, images.options());
}

}  // namespace ertbench
