#include "models/inference/dense_step.h"

#include <algorithm>
#include <stdexcept>

namespace ertbench {
namespace {

constexpr int most_blocks = 8 / block_vectors;  ///< of a group

/// The next group of blocks, of 8, 4, 2 or 1.
int group_of(int blocks_left) {
  int group = most_blocks;
  while (group > blocks_left) group /= 2;
  return group;
}

/// Sums of `group` blocks; returns where the weights of the next group begin.
template <int group, typename Weight>
const Weight* multiply(const Weight* weights, const float* x, int inputs, const float* bias,
                       bool rectified, float* y) {
  constexpr int vectors = group * block_vectors;
  // Sums that follow on themselves wait for each other: a small group takes the inputs in turns.
  constexpr int turns = vectors >= 4 ? 1 : 4 / vectors;
  Native sums[turns][vectors] = {};
  int i = 0;
  for (; i + turns <= inputs; i += turns) {
#pragma GCC unroll 4
    for (int t = 0; t < turns; ++t) {
#pragma GCC unroll 8
      for (int v = 0; v < vectors; ++v, weights += native_lanes) {
        Native weight;
        load(weight, weights);
        sums[t][v] += weight * x[i + t];
      }
    }
  }
  for (; i < inputs; ++i) {
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v, weights += native_lanes) {
      Native weight;
      load(weight, weights);
      sums[0][v] += weight * x[i];
    }
  }
#pragma GCC unroll 8
  for (int v = 0; v < vectors; ++v) {
    Native out;
    load(out, bias + v * native_lanes);
#pragma GCC unroll 4
    for (int t = 0; t < turns; ++t) out += sums[t][v];
    if (rectified) relu(out);
    store(y + v * native_lanes, out);
  }
  return weights;
}

template <typename Weight>
const Weight* multiply(int group, const Weight* weights, const float* x, int inputs,
                       const float* bias, bool rectified, float* y) {
  if constexpr (most_blocks >= 8) {
    if (group == 8) return multiply<8>(weights, x, inputs, bias, rectified, y);
  }
  if constexpr (most_blocks >= 4) {
    if (group == 4) return multiply<4>(weights, x, inputs, bias, rectified, y);
  }
  if (group == 2) return multiply<2>(weights, x, inputs, bias, rectified, y);
  return multiply<1>(weights, x, inputs, bias, rectified, y);
}

}  // namespace

DenseStep::DenseStep(int input, int output, const DenseWeights& weights,
                     const Activation& activation, bool bfloat16)
    : input_(input),
      output_(output),
      inputs_(weights.inputs),
      blocks_((weights.outputs + lanes - 1) / lanes),
      activation_(activation.kind),
      bias_(weights.bias) {
  if (activation_ == Activation::Kind::prelu) {
    throw std::logic_error("a dense layer of a plan has no PReLU");
  }
  bias_.resize(static_cast<std::size_t>(blocks_ * lanes));
  for (int first = 0; first < blocks_;) {
    const int group = group_of(blocks_ - first);
    for (int i = 0; i < inputs_; ++i) {
      for (int o = first * lanes; o < (first + group) * lanes; ++o) {
        const auto at = static_cast<std::size_t>(o) * static_cast<std::size_t>(inputs_) +
                        static_cast<std::size_t>(i);
        const float weight = o < weights.outputs ? weights.weights[at] : 0.0F;
        if (bfloat16) {
          rounded_.push_back(to_bfloat16(weight));
        } else {
          weights_.push_back(weight);
        }
      }
    }
    first += group;
  }
}

void DenseStep::prepare(Layouts layouts) {
  from_ = layouts[static_cast<std::size_t>(input_)].channel(0);
  to_ = layouts[static_cast<std::size_t>(output_)].channel(0);
}

template <typename Weight>
void DenseStep::run_with(const std::vector<Weight>& weights, float* workspace) const {
  const Weight* next = weights.data();
  for (int first = 0; first < blocks_;) {
    const int group = group_of(blocks_ - first);
    next = multiply(group, next, workspace + from_, inputs_, bias_.data() + first * lanes,
                    activation_ == Activation::Kind::relu, workspace + to_ + first * lanes);
    first += group;
  }
}

void DenseStep::run(float* workspace) const {
  if (rounded_.empty()) {
    run_with(weights_, workspace);
  } else {
    run_with(rounded_, workspace);
  }
}

}  // namespace ertbench
