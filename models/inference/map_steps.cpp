#include "models/inference/map_steps.h"

#include <Eigen/Core>
#include <algorithm>

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

}  // namespace ertbench
