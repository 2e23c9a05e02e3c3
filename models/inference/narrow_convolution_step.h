#pragma once

#include <utility>
#include <vector>

#include "models/inference/inference_plan.h"
#include "models/inference/plan_builder.h"

namespace ertbench {

/// A convolution of stride 1 from blocked maps to at most four planar ones: where there are so few
/// outputs, the lanes of a vector are 16 input channels, whose products are added in the end.
class NarrowConvolutionStep final : public PlanStep {
 public:
  static constexpr int most_outputs = 4;

  NarrowConvolutionStep(int input, int output, ConvolutionWeights weights)
      : input_(input), output_(output), shape_(std::move(weights)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  template <int outputs, int pixels>
  void convolve(float* workspace, std::ptrdiff_t input, std::ptrdiff_t output) const;
  template <int outputs>
  void run_with(float* workspace) const;

  int input_;
  int output_;
  ConvolutionWeights shape_;
  std::vector<float> weights_;          ///< [block of inputs][kernel][kernel][outputs][16]
  std::vector<std::ptrdiff_t> blocks_;  ///< where each block of inputs begins
  MapLayout from_;
  MapLayout to_;
};

}  // namespace ertbench
