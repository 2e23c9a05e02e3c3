#pragma once

#include <cstdint>
#include <vector>

#include "models/inference/inference_plan.h"

/// Steps that are small beside dense layers and convolutions.
namespace ertbench {

/// Permutes the numbers of a vector; -1 gives 0.
class GatherStep final : public PlanStep {
 public:
  GatherStep(int input, int output, std::vector<int> sources)
      : input_(input), output_(output), sources_(std::move(sources)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int input_;
  int output_;
  std::vector<int> sources_;
  std::ptrdiff_t from_ = 0;
  std::ptrdiff_t to_ = 0;
};

/// Means of pairs of a vector's numbers.
class MeansStep final : public PlanStep {
 public:
  /// `pairs` [outputs][2].
  MeansStep(int input, int output, std::vector<int> pairs)
      : input_(input), output_(output), pairs_(std::move(pairs)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int input_;
  int output_;
  std::vector<int> pairs_;
  std::ptrdiff_t from_ = 0;
  std::ptrdiff_t to_ = 0;
};

/// A vector as planar maps with their border.
class MapsStep final : public PlanStep {
 public:
  MapsStep(int input, int output) : input_(input), output_(output) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int input_;
  int output_;
  std::ptrdiff_t from_ = 0;
  MapLayout to_;
};

/// Maximum over each 2 x 2 pixels of blocked maps.
class PoolStep final : public PlanStep {
 public:
  PoolStep(int input, int output) : input_(input), output_(output) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int input_;
  int output_;
  MapLayout from_;
  MapLayout to_;
};

/// Interleaves four planar maps to one of twice the side, with map 2 (row % 2) + column % 2 at row,
/// column, and adds the same of four others.
class ShuffleStep final : public PlanStep {
 public:
  ShuffleStep(int input, int output, int added) : input_(input), output_(output), added_(added) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int input_;
  int output_;
  int added_;
  MapLayout from_;
  MapLayout to_;
  MapLayout plus_;
};

/// 1 / (1 + exp(-x)) of planar maps, in place.
class SigmoidStep final : public PlanStep {
 public:
  explicit SigmoidStep(int maps) : maps_(maps) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int maps_;
  MapLayout layout_;
};

/// The mean of a mixture: estimates, weighted by the probabilities of their components.
class MixtureStep final : public PlanStep {
 public:
  MixtureStep(int whitened, int input, int output, DenseWeights estimates)
      : whitened_(whitened), input_(input), output_(output), estimates_(std::move(estimates)) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int whitened_;
  int input_;
  int output_;
  DenseWeights estimates_;
  MapLayout scores_;
  std::ptrdiff_t from_ = 0;
  std::ptrdiff_t to_ = 0;
};

/// Initialises blocked maps with the bias and the added value, for passes that add to them.
class FillStep final : public PlanStep {
 public:
  FillStep(int output, std::vector<float> bias, int added)
      : output_(output), bias_(std::move(bias)), added_(added) {}
  void prepare(Layouts layouts) override;
  void run(float* workspace) const override;

 private:
  int output_;
  std::vector<float> bias_;
  int added_;
  MapLayout to_;
  MapLayout plus_;
};

/// y = activation(W x + b). Reads its weights once, sequentially: for each group of outputs, whose
/// sums are in registers, input by input.
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
