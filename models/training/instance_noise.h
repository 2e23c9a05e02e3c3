#pragma once

#include <torch/types.h>

#include <cstdint>

namespace ertbench {

/// Gaussian noise on all that a discriminator sees, truths and images alike, so that it cannot tell
/// them by traits too fine for a generator to follow (Sønderby et al. 2017). It falls in a straight
/// line to 0 over the training. What a step draws depends on (seed, step) alone.
class InstanceNoise {
 public:
  /// `deviation`: its standard deviation at the first step, in units of y; 0: none, and then
  /// nothing is drawn.
  InstanceNoise(double deviation, std::uint64_t seed) : largest_(deviation), seed_(seed) {}

  /// Steps count from 0; the last is `steps` - 1 and has no noise. Of a training of one step, that
  /// one has all of it.
  void begin_step(std::uint64_t step, std::uint64_t steps);
  /// The standard deviation in this step.
  double deviation() const { return deviation_; }
  /// Each call of a step draws other noise.
  torch::Tensor add_to(const torch::Tensor& images);

 private:
  double largest_;
  std::uint64_t seed_;
  double deviation_ = 0;
  torch::Generator generator_;
};

}  // namespace ertbench
