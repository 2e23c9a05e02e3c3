#include "models/inference/attention_step.h"

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace ertbench {

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
