#include "models/inference/narrow_convolution_step.h"

namespace ertbench {

void NarrowConvolutionStep::prepare(Layouts layouts) {
  from_ = layouts[static_cast<std::size_t>(input_)];
  to_ = layouts[static_cast<std::size_t>(output_)];
  const int taps = shape_.kernel * shape_.kernel;
  for (int block = 0; block < from_.blocks(); ++block) {
    blocks_.push_back(from_.block(block) - shape_.padding * (from_.row() + from_.pixel()));
    for (int tap = 0; tap < taps; ++tap) {
      for (int o = 0; o < shape_.outputs; ++o) {
        for (int i = block * lanes; i < (block + 1) * lanes; ++i) {
          const int at = (o * shape_.inputs + i) * taps + tap;
          weights_.push_back(i < shape_.inputs ? shape_.weights[static_cast<std::size_t>(at)]
                                               : 0.0F);
        }
      }
    }
  }
  shape_.weights = {};
}

template <int outputs, int pixels>
void NarrowConvolutionStep::convolve(float* workspace, std::ptrdiff_t input,
                                     std::ptrdiff_t output) const {
  Native sums[outputs][pixels] = {};
  const float* weights = weights_.data();
  const std::ptrdiff_t row = from_.row();
  for (const std::ptrdiff_t block : blocks_) {
    const float* from = workspace + block + input;
    for (int ky = 0; ky < shape_.kernel; ++ky, from += row) {
      const float* x = from;
      for (int kx = 0; kx < shape_.kernel; ++kx, x += lanes, weights += outputs * lanes) {
#pragma GCC unroll 4
        for (int v = 0; v < block_vectors; ++v) {
#pragma GCC unroll 8
          for (int p = 0; p < pixels; ++p) {
            Native values;
            load(values, x + p * lanes + v * native_lanes);
#pragma GCC unroll 4
            for (int o = 0; o < outputs; ++o) {
              Native weight;
              load(weight, weights + o * lanes + v * native_lanes);
              sums[o][p] += weight * values;
            }
          }
        }
      }
    }
  }
#pragma GCC unroll 4
  for (int o = 0; o < outputs; ++o) {
    float* to = workspace + to_.channel(o) + output;
#pragma GCC unroll 8
    for (int p = 0; p < pixels; ++p) {
      to[p] = sum(sums[o][p]) + shape_.bias[static_cast<std::size_t>(o)];
    }
  }
}

template <int outputs>
void NarrowConvolutionStep::run_with(float* workspace) const {
  constexpr int pixels = outputs > 2 ? sum_registers / 6 : sum_registers / 3;
  for (int y = 0; y < to_.height; ++y) {
    int x = 0;
    for (; x + pixels <= to_.width; x += pixels) {
      convolve<outputs, pixels>(workspace, y * from_.row() + x * lanes, y * to_.row() + x);
    }
    for (; x < to_.width; ++x) {
      convolve<outputs, 1>(workspace, y * from_.row() + x * lanes, y * to_.row() + x);
    }
  }
}

void NarrowConvolutionStep::run(float* workspace) const {
  switch (shape_.outputs) {
    case 1:
      return run_with<1>(workspace);
    case 2:
      return run_with<2>(workspace);
    case 3:
      return run_with<3>(workspace);
    default:
      return run_with<4>(workspace);
  }
}

}  // namespace ertbench
