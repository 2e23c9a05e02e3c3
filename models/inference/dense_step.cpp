#include "models/inference/dense_step.h"

#include <algorithm>
#include <stdexcept>

namespace ertbench {
namespace {

constexpr int most_blocks = register_tile >= 8 ? 8 : 4;  ///< of a group

void load_weights(Float16& out, const float* from) { load(out, from); }
void load_weights(Float16& out, const std::uint16_t* from) { load_bfloat16(out, from); }

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
  // Sums that follow on themselves wait for each other: a small group takes the inputs in turns.
  constexpr int turns = group >= 4 ? 1 : 4 / group;
  Float16 sums[turns][group] = {};
  int i = 0;
  for (; i + turns <= inputs; i += turns) {
    for (int t = 0; t < turns; ++t) {
      for (int b = 0; b < group; ++b, weights += lanes) {
        Float16 weight;
        load_weights(weight, weights);
        sums[t][b] += weight * x[i + t];
      }
    }
  }
  for (; i < inputs; ++i) {
    for (int b = 0; b < group; ++b, weights += lanes) {
      Float16 weight;
      load_weights(weight, weights);
      sums[0][b] += weight * x[i];
    }
  }
  for (int b = 0; b < group; ++b) {
    Float16 out;
    load(out, bias + b * lanes);
    for (int t = 0; t < turns; ++t) out += sums[t][b];
    if (rectified) relu(out);
    store(y + b * lanes, out);
  }
  return weights;
}

template <typename Weight>
const Weight* multiply(int group, const Weight* weights, const float* x, int inputs,
                       const float* bias, bool rectified, float* y) {
  switch (group) {
    case 8:
      return multiply<8>(weights, x, inputs, bias, rectified, y);
    case 4:
      return multiply<4>(weights, x, inputs, bias, rectified, y);
    case 2:
      return multiply<2>(weights, x, inputs, bias, rectified, y);
    default:
      return multiply<1>(weights, x, inputs, bias, rectified, y);
  }
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
