#include "models/inference/map_steps.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace ertbench {
namespace {

const MapLayout& of(Layouts layouts, int value) { return layouts[static_cast<std::size_t>(value)]; }

}  // namespace

void GatherStep::prepare(Layouts layouts) {
  from_ = of(layouts, input_).channel(0);
  to_ = of(layouts, output_).channel(0);
}

void GatherStep::run(float* workspace) const {
  float* to = workspace + to_;
  for (const int source : sources_) *to++ = source < 0 ? 0.0F : workspace[from_ + source];
}

void MeansStep::prepare(Layouts layouts) {
  from_ = of(layouts, input_).channel(0);
  to_ = of(layouts, output_).channel(0);
}

void MeansStep::run(float* workspace) const {
  float* to = workspace + to_;
  const float* from = workspace + from_;
  for (std::size_t i = 0; i < pairs_.size(); i += 2) {
    *to++ = (from[pairs_[i]] + from[pairs_[i + 1]]) / 2;
  }
}

void MapsStep::prepare(Layouts layouts) {
  from_ = of(layouts, input_).channel(0);
  to_ = of(layouts, output_);
}

void MapsStep::run(float* workspace) const {
  const float* from = workspace + from_;
  for (int channel = 0; channel < to_.channels; ++channel) {
    float* row = workspace + to_.channel(channel);
    for (int y = 0; y < to_.height; ++y, row += to_.row(), from += to_.width) {
      std::copy_n(from, to_.width, row);
    }
  }
}

void PoolStep::prepare(Layouts layouts) {
  from_ = of(layouts, input_);
  to_ = of(layouts, output_);
}

void PoolStep::run(float* workspace) const {
  for (int block = 0; block < to_.blocks(); ++block) {
    for (int y = 0; y < to_.height; ++y) {
      const float* from = workspace + from_.block(block) + 2 * y * from_.row();
      float* to = workspace + to_.block(block) + y * to_.row();
      for (int x = 0; x < to_.width; ++x, from += 2 * lanes, to += lanes) {
        Floats<lanes> most;
        load(most, from);
        for (const std::ptrdiff_t other : {from_.pixel(), from_.row(), from_.row() + lanes}) {
          Floats<lanes> value;
          load(value, from + other);
          most = value > most ? value : most;
        }
        store(to, most);
      }
    }
  }
}

void ShuffleStep::prepare(Layouts layouts) {
  from_ = of(layouts, input_);
  to_ = of(layouts, output_);
  if (added_ >= 0) plus_ = of(layouts, added_);
}

void ShuffleStep::run(float* workspace) const {
  for (int channel = 0; channel < 4; ++channel) {
    for (int y = 0; y < from_.height; ++y) {
      const float* from = workspace + from_.channel(channel) + y * from_.row();
      float* to = workspace + to_.channel(0) + (2 * y + channel / 2) * to_.row() + channel % 2;
      for (int x = 0; x < from_.width; ++x) to[2 * x] = from[x];
      if (added_ < 0) continue;
      const float* plus = workspace + plus_.channel(channel) + y * plus_.row();
      for (int x = 0; x < from_.width; ++x) to[2 * x] += plus[x];
    }
  }
}

void SigmoidStep::prepare(Layouts layouts) { layout_ = of(layouts, maps_); }

void SigmoidStep::run(float* workspace) const {
  for (int channel = 0; channel < layout_.channels; ++channel) {
    float* row = workspace + layout_.channel(channel);
    for (int y = 0; y < layout_.height; ++y, row += layout_.row()) {
      Eigen::Map<Eigen::ArrayXf> x(row, layout_.width);
      x = 1.0F / (1.0F + (-x).exp());
    }
  }
}

void MixtureStep::prepare(Layouts layouts) {
  scores_ = of(layouts, whitened_);
  from_ = of(layouts, input_).channel(0);
  to_ = of(layouts, output_).channel(0);
}

void MixtureStep::run(float* workspace) const {
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Eigen::Index outputs = estimates_.outputs;
  const Eigen::Index components = std::ssize(estimates_.bias) / (outputs + 1);
  const Eigen::Map<const Rows> constants(estimates_.bias.data(), components, outputs + 1);
  float* const whitened = workspace + scores_.channel(0);
  const Eigen::Map<const Rows> gates(whitened, components, scores_.width / components);
  Eigen::Map<Eigen::ArrayXf> scores(whitened, components);  // in the place of what is read before
  for (Eigen::Index k = 0; k < components; ++k) {
    scores[k] = constants(k, 0) - gates.row(k).squaredNorm() / 2;
  }
  scores = (scores - scores.maxCoeff()).exp();
  const float sum = (scores < least_mixture_share).select(0.0F, scores).sum();
  const Eigen::Map<const Eigen::VectorXf> x(workspace + from_, estimates_.inputs);
  Eigen::Map<Eigen::VectorXf> out(workspace + to_, outputs);
  out.setZero();
  const float* weights = estimates_.weights.data();
  for (Eigen::Index k = 0; k < components; ++k, weights += outputs * x.size()) {
    if (scores[k] < least_mixture_share) continue;
    const float share = scores[k] / sum;
    out += share * constants.row(k).tail(outputs).transpose();
    out.noalias() += share * (Eigen::Map<const Rows>(weights, outputs, x.size()) * x);
  }
}

void FillStep::prepare(Layouts layouts) {
  to_ = of(layouts, output_);
  if (added_ >= 0) plus_ = of(layouts, added_);
  bias_.resize(static_cast<std::size_t>(to_.blocks() * lanes));
}

void FillStep::run(float* workspace) const {
  for (int block = 0; block < to_.blocks(); ++block) {
    Floats<lanes> bias;
    load(bias, bias_.data() + block * lanes);
    for (int y = 0; y < to_.height; ++y) {
      float* to = workspace + to_.block(block) + y * to_.row();
      for (int x = 0; x < to_.width; ++x, to += lanes) {
        Floats<lanes> value = bias;
        if (added_ >= 0) {
          Floats<lanes> plus;
          load(plus, workspace + plus_.block(block) + y * plus_.row() + x * lanes);
          value += plus;
        }
        store(to, value);
      }
    }
  }
}

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

void AttentionStep::prepare(Layouts layouts) {
  from_ = layouts[static_cast<std::size_t>(input_)];
  between_ = layouts[static_cast<std::size_t>(summary_)];
  to_ = layouts[static_cast<std::size_t>(output_)];
}

/// Mean and maximum over the channels.
void AttentionStep::summarise(float* workspace) const {
  using Lanes = Eigen::Array<float, lanes, 1>;
  const int last = from_.channels - (from_.blocks() - 1) * lanes;  // channels of the last block
  Lanes unused = Lanes::Zero();
  unused.tail(lanes - last).setConstant(-std::numeric_limits<float>::infinity());
  for (int y = 0; y < from_.height; ++y) {
    for (int x = 0; x < from_.width; ++x) {
      const float* pixel = workspace + from_.block(0) + y * from_.row() + x * from_.pixel();
      Lanes total = Lanes::Zero();
      Lanes most = Lanes::Constant(-std::numeric_limits<float>::infinity());
      for (int block = 0; block < from_.blocks(); ++block, pixel += from_.plane()) {
        const Lanes values = Eigen::Map<const Lanes>(pixel);
        total += values;
        if (block + 1 < from_.blocks()) {
          most = most.max(values);
        } else {
          most = most.max(values + unused);
        }
      }
      const std::ptrdiff_t place = y * between_.row() + x;
      workspace[between_.channel(0) + place] = total.sum() / static_cast<float>(from_.channels);
      workspace[between_.channel(1) + place] = most.maxCoeff();
    }
  }
}

void AttentionStep::weigh(float* workspace, int y, int first, const float* factors,
                          int count) const {
  for (int block = 0; block < from_.blocks(); ++block) {
    const float* from = workspace + from_.block(block) + y * from_.row() + first * lanes;
    float* to = workspace + to_.block(block) + y * to_.row() + first * lanes;
    for (int x = 0; x < count; ++x, from += lanes, to += lanes) {
      Floats<lanes> values;
      load(values, from);
      values *= factors[x];
      store(to, values);
    }
  }
}

void AttentionStep::run(float* workspace) const {
  summarise(workspace);
  const std::ptrdiff_t corner = (kernel_ / 2) * (between_.row() + 1);
  for (int y = 0; y < from_.height; ++y) {
    // Lanes past the width read other rows, or what stands behind the maps, and are not used.
    for (int first = 0; first < from_.width; first += lanes) {
      Floats<lanes> sums = {};
      const float* weight = weights_.data();
      for (int map = 0; map < 2; ++map) {
        const float* row = workspace + between_.channel(map) - corner + y * between_.row() + first;
        for (int ky = 0; ky < kernel_; ++ky, row += between_.row()) {
          for (int kx = 0; kx < kernel_; ++kx, ++weight) {
            Floats<lanes> values;
            load(values, row + kx);
            sums += *weight * values;
          }
        }
      }
      Eigen::Array<float, lanes, 1> factors;
      store(factors.data(), sums);
      factors = 1.0F / (1.0F + (-factors).exp());
      weigh(workspace, y, first, factors.data(), std::min(lanes, from_.width - first));
    }
  }
}

}  // namespace ertbench
