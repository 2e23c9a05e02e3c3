#pragma once

#include <vector>

#include "models/inference/inference_plan.h"

namespace ertbench {

/// Spatial attention (B2 of the DD-ERT supplement) on blocked maps:
///
///     y = x sigmoid(convolution of [mean over the channels; maximum over the channels]).
class AttentionStep final : public PlanStep {
 public:
  /// `summary`: two planar maps with a border of half the kernel, which this step fills;
  /// `weights` [2][kernel][kernel].
  AttentionStep(int input, int summary, int output, int kernel, std::vector<float> weights)
      : input_(input),
        summary_(summary),
        output_(output),
        kernel_(kernel),
        weights_(std::move(weights)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  void summarise(float* workspace) const;
  void weigh(float* workspace, int y, int first, const float* factors, int count) const;

  int input_;
  int summary_;
  int output_;
  int kernel_;
  std::vector<float> weights_;
  MapLayout from_;
  MapLayout between_;
  MapLayout to_;
};

}  // namespace ertbench
