#pragma once

#include <cstdint>
#include <vector>

#include "models/inference/inference_plan.h"
#include "models/inference/plan_builder.h"

namespace ertbench {

/// y = activation(W x + b). Its weights are read once, in the order in which they lie: for each
/// group of outputs, which has its sums in registers, input after input.
class DenseStep final : public PlanStep {
 public:
  DenseStep(int input, int output, const DenseWeights& weights, const Activation& activation,
            bool bfloat16);
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  template <typename Weight>
  void run_with(const std::vector<Weight>& weights, float* workspace) const;

  int input_;
  int output_;
  int inputs_;
  int blocks_;  ///< of 16 outputs
  Activation::Kind activation_;
  std::vector<float> weights_;          ///< [group][inputs][blocks of the group][16]
  std::vector<std::uint16_t> rounded_;  ///< the same in bfloat16; one of the two is empty
  std::vector<float> bias_;             ///< [16 blocks]
  std::ptrdiff_t from_ = 0;
  std::ptrdiff_t to_ = 0;
};

}  // namespace ertbench
