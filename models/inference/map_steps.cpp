#include "models/inference/map_steps.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "core/arrays.h"

namespace ertbench {

MapFunction gather_numbers(std::vector<int> sources) {
  return [sources = std::move(sources)](float* workspace, Layouts values) {
    const float* from = workspace + values[0].channel(0);
    float* to = workspace + values[1].channel(0);
    for (const int source : sources) *to++ = source < 0 ? 0.0F : from[source];
  };
}

MapFunction mean_pairs(std::vector<int> pairs) {
  return [pairs = std::move(pairs)](float* workspace, Layouts values) {
    const float* from = workspace + values[0].channel(0);
    float* to = workspace + values[1].channel(0);
    for (std::size_t i = 0; i < pairs.size(); i += 2) {
      *to++ = (from[pairs[i]] + from[pairs[i + 1]]) / 2;
    }
  };
}

void lay_maps(float* workspace, Layouts values) {
  const float* from = workspace + values[0].channel(0);
  const MapLayout& maps = values[1];
  for (int channel = 0; channel < maps.channels; ++channel) {
    float* row = workspace + maps.channel(channel);
    for (int y = 0; y < maps.height; ++y, row += maps.row(), from += maps.width) {
      std::copy_n(from, maps.width, row);
    }
  }
}

void pool_maps(float* workspace, Layouts values) {
  const MapLayout& large = values[0];
  const MapLayout& small = values[1];
  for (int block = 0; block < small.blocks(); ++block) {
    for (int y = 0; y < small.height; ++y) {
      const float* from = workspace + large.block(block) + 2 * y * large.row();
      float* to = workspace + small.block(block) + y * small.row();
      for (int x = 0; x < small.width; ++x, from += 2 * lanes, to += lanes) {
        Floats<lanes> most;
        load(most, from);
        for (const std::ptrdiff_t other : {large.pixel(), large.row(), large.row() + lanes}) {
          Floats<lanes> value;
          load(value, from + other);
          most = value > most ? value : most;
        }
        store(to, most);
      }
    }
  }
}

void shuffle_maps(float* workspace, Layouts values) {
  const MapLayout& small = values[0];
  const MapLayout& large = values[1];
  for (int channel = 0; channel < 4; ++channel) {
    for (int y = 0; y < small.height; ++y) {
      const float* from = workspace + small.channel(channel) + y * small.row();
      float* to = workspace + large.channel(0) + (2 * y + channel / 2) * large.row() + channel % 2;
      for (int x = 0; x < small.width; ++x) to[2 * x] = from[x];
      if (values.size() < 3) continue;
      const float* added = workspace + values[2].channel(channel) + y * values[2].row();
      for (int x = 0; x < small.width; ++x) to[2 * x] += added[x];
    }
  }
}

void sigmoid_maps(float* workspace, Layouts values) {
  const MapLayout& maps = values[0];
  for (int channel = 0; channel < maps.channels; ++channel) {
    float* row = workspace + maps.channel(channel);
    for (int y = 0; y < maps.height; ++y, row += maps.row()) {
      Eigen::Map<Eigen::ArrayXf> x(row, maps.width);
      x = 1.0F / (1.0F + (-x).exp());
    }
  }
}

MapFunction average_mixture(DenseWeights estimates) {
  return [estimates = std::move(estimates)](float* workspace, Layouts values) {
    const Eigen::Index outputs = estimates.outputs;
    const Eigen::Index components = std::ssize(estimates.bias) / (outputs + 1);
    const Eigen::Map<const FloatRows> constants(estimates.bias.data(), components, outputs + 1);
    float* const whitened = workspace + values[0].channel(0);
    const Eigen::Map<const FloatRows> gates(whitened, components, values[0].width / components);
    Eigen::Map<Eigen::ArrayXf> scores(whitened, components);  // in the place of what is read before
    for (Eigen::Index k = 0; k < components; ++k) {
      scores[k] = constants(k, 0) - gates.row(k).squaredNorm() / 2;
    }
    scores = (scores - scores.maxCoeff()).exp();
    const float sum = (scores < least_mixture_share).select(0.0F, scores).sum();
    const Eigen::Map<const Eigen::VectorXf> x(workspace + values[1].channel(0), estimates.inputs);
    Eigen::Map<Eigen::VectorXf> out(workspace + values[2].channel(0), outputs);
    out.setZero();
    const float* weights = estimates.weights.data();
    for (Eigen::Index k = 0; k < components; ++k, weights += outputs * x.size()) {
      if (scores[k] < least_mixture_share) continue;
      const float share = scores[k] / sum;
      out += share * constants.row(k).tail(outputs).transpose();
      out.noalias() += share * (Eigen::Map<const FloatRows>(weights, outputs, x.size()) * x);
    }
  };
}

MapFunction fill_maps(std::vector<float> bias) {
  return [bias = std::move(bias)](float* workspace, Layouts values) {
    const MapLayout& maps = values[0];
    for (int block = 0; block < maps.blocks(); ++block) {
      Floats<lanes> constant;
      load(constant, bias.data() + block * lanes);
      for (int y = 0; y < maps.height; ++y) {
        float* to = workspace + maps.block(block) + y * maps.row();
        for (int x = 0; x < maps.width; ++x, to += lanes) {
          Floats<lanes> value = constant;
          if (values.size() > 1) {
            const MapLayout& added = values[1];
            Floats<lanes> plus;
            load(plus, workspace + added.block(block) + y * added.row() + x * lanes);
            value += plus;
          }
          store(to, value);
        }
      }
    }
  };
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

MapFunction multiply_dense(const DenseWeights& layer, Activation::Kind activation, bool bfloat16) {
  if (activation == Activation::Kind::prelu) {
    throw std::logic_error("a dense layer of a plan has no PReLU");
  }
  const int inputs = layer.inputs;
  const int blocks = (layer.outputs + lanes - 1) / lanes;
  const bool rectified = activation == Activation::Kind::relu;
  std::vector<float> bias = layer.bias;
  bias.resize(static_cast<std::size_t>(blocks * lanes));
  // The weights as `stored` has them, [group][inputs][blocks of the group][16].
  const auto product = [&](auto&& stored) -> MapFunction {
    std::vector<decltype(stored(0.0F))> weights;
    for (int first = 0; first < blocks;) {
      const int group = group_of(blocks - first);
      for (int i = 0; i < inputs; ++i) {
        for (int o = first * lanes; o < (first + group) * lanes; ++o) {
          const auto at = static_cast<std::size_t>(o) * static_cast<std::size_t>(inputs) +
                          static_cast<std::size_t>(i);
          weights.push_back(stored(o < layer.outputs ? layer.weights[at] : 0.0F));
        }
      }
      first += group;
    }
    return [=, weights = std::move(weights)](float* workspace, Layouts values) {
      const float* const from = workspace + values[0].channel(0);
      float* const to = workspace + values[1].channel(0);
      const auto* next = weights.data();
      for (int first = 0; first < blocks;) {
        const int group = group_of(blocks - first);
        next = multiply(group, next, from, inputs, bias.data() + first * lanes, rectified,
                        to + first * lanes);
        first += group;
      }
    };
  };
  return bfloat16 ? product(to_bfloat16) : product([](float weight) { return weight; });
}

namespace {

/// Mean and maximum over the channels.
void summarise(float* workspace, const MapLayout& from, const MapLayout& summary) {
  using Lanes = Eigen::Array<float, lanes, 1>;
  const int last = from.channels - (from.blocks() - 1) * lanes;  // channels of the last block
  Lanes unused = Lanes::Zero();
  unused.tail(lanes - last).setConstant(-std::numeric_limits<float>::infinity());
  for (int y = 0; y < from.height; ++y) {
    for (int x = 0; x < from.width; ++x) {
      const float* pixel = workspace + from.block(0) + y * from.row() + x * from.pixel();
      Lanes total = Lanes::Zero();
      Lanes most = Lanes::Constant(-std::numeric_limits<float>::infinity());
      for (int block = 0; block < from.blocks(); ++block, pixel += from.plane()) {
        const Lanes values = Eigen::Map<const Lanes>(pixel);
        total += values;
        if (block + 1 < from.blocks()) {
          most = most.max(values);
        } else {
          most = most.max(values + unused);
        }
      }
      const std::ptrdiff_t place = y * summary.row() + x;
      workspace[summary.channel(0) + place] = total.sum() / static_cast<float>(from.channels);
      workspace[summary.channel(1) + place] = most.maxCoeff();
    }
  }
}

/// Multiplies the pixels from `first` on in a row.
void weigh(float* workspace, const MapLayout& large, const MapLayout& same, int y, int first,
           const float* factors, int count) {
  for (int block = 0; block < large.blocks(); ++block) {
    const float* from = workspace + large.block(block) + y * large.row() + first * lanes;
    float* to = workspace + same.block(block) + y * same.row() + first * lanes;
    for (int x = 0; x < count; ++x, from += lanes, to += lanes) {
      Floats<lanes> values;
      load(values, from);
      values *= factors[x];
      store(to, values);
    }
  }
}

}  // namespace

MapFunction attend_maps(int kernel, std::vector<float> weights) {
  return [kernel, weights = std::move(weights)](float* workspace, Layouts values) {
    const MapLayout& from = values[0];
    const MapLayout& summary = values[1];
    summarise(workspace, from, summary);
    const std::ptrdiff_t corner = (kernel / 2) * (summary.row() + 1);
    for (int y = 0; y < from.height; ++y) {
      // Lanes past the width read other rows, or what stands behind the maps, and are not used.
      for (int first = 0; first < from.width; first += lanes) {
        Floats<lanes> sums = {};
        const float* weight = weights.data();
        for (int map = 0; map < 2; ++map) {
          const float* row = workspace + summary.channel(map) - corner + y * summary.row() + first;
          for (int ky = 0; ky < kernel; ++ky, row += summary.row()) {
            for (int kx = 0; kx < kernel; ++kx, ++weight) {
              Floats<lanes> pixels;
              load(pixels, row + kx);
              sums += *weight * pixels;
            }
          }
        }
        Eigen::Array<float, lanes, 1> factors;
        store(factors.data(), sums);
        factors = 1.0F / (1.0F + (-factors).exp());
        weigh(workspace, from, values[2], y, first, factors.data(),
              std::min(lanes, from.width - first));
      }
    }
  };
}

}  // namespace ertbench
