// What the values of a program reach: its steps in floats.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/export/layer_program.h"

namespace ertbench {

float window_sum(const ExportStep& step, const ExportProgram::Value& from,
                 const std::vector<float>& numbers, int output, int row, int column) {
  float sum = step.bias[index_of(output)];
  for (int y = 0; y < step.kernel; ++y) {
    for (int x = 0; x < step.kernel; ++x) {
      const int r = row * step.stride - step.padding + y;
      const int c = column * step.stride - step.padding + x;
      if (r < 0 || r >= from.rows || c < 0 || c >= from.columns) continue;
      const int tap = (output * step.kernel + y) * step.kernel + x;
      const float* weights = &step.weights[index_of(tap * from.channels)];
      const float* pixel = &numbers[index_of((r * from.columns + c) * from.channels)];
      for (int i = 0; i < from.channels; ++i) sum += weights[i] * pixel[i];
    }
  }
  return sum;
}

namespace {

using StepKind = ExportStep::Kind;

/// Sums of a convolution over the pixels of its output, which is complete behind its last tap.
void convolve(const ExportProgram& program, const ExportStep& step,
              std::vector<std::vector<float>>& numbers) {
  const std::vector<float>& in = numbers[index_of(step.inputs[0])];
  std::vector<float>& out = numbers[index_of(step.value)];
  const int columns = program.sum_columns(step);
  for (int i = 0; i < program.sum_rows(step) * columns * step.outputs; ++i) {
    const int output = i % step.outputs;
    const int row = i / step.outputs / columns;
    const int column = i / step.outputs % columns;
    const int pixel =
        (row * step.spread + step.row) * columns * step.spread + column * step.spread + step.column;
    float sum = window_sum(step, program.value(step.inputs[0]), in, output, row, column);
    if (step.added >= 0) {
      const int channels = program.value(step.added).channels;
      sum += numbers[index_of(step.added)][index_of(pixel * channels + output)];
    }
    out[index_of(pixel * step.outputs + output)] = step.relu ? std::max(sum, 0.0F) : sum;
  }
}

/// The steps that work on each number or pixel by itself.
void compute(const ExportProgram& program, const ExportStep& step,
             std::vector<std::vector<float>>& numbers) {
  const ExportProgram::Value& from = program.value(step.inputs[0]);
  const std::vector<float>& in = numbers[index_of(step.inputs[0])];
  std::vector<float>& out = numbers[index_of(step.value)];
  const auto channels = index_of(from.channels);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (step.kind == StepKind::sums_of_pairs) {
      out[i] = in[index_of(step.indices[2 * i])] + in[index_of(step.indices[2 * i + 1])];
    } else if (step.kind == StepKind::gather) {
      out[i] = step.indices[i] < 0 ? 0 : in[index_of(step.indices[i])];
    } else if (step.kind == StepKind::prelu) {
      out[i] = std::max(in[i], 0.0F) + step.weights[i % channels] * std::min(in[i], 0.0F);
    } else if (step.kind == StepKind::shuffle) {
      out[i] = in[i];  // in another order, of which ranges do not depend
    } else if (step.kind == StepKind::pool) {
      const auto row = index_of(from.columns) * channels;
      const std::size_t pixel = i / channels;
      const auto columns = index_of(program.value(step.value).columns);
      const float* const first =
          &in[pixel / columns * 2 * row + pixel % columns * 2 * channels + i % channels];
      out[i] = std::max({first[0], first[channels], first[row], first[row + channels]});
    } else if (step.kind == StepKind::summarise) {
      const auto first = in.begin() + static_cast<std::ptrdiff_t>(i / 2 * channels);
      const auto end = first + from.channels;
      out[i] = i % 2 == 0 ? std::accumulate(first, end, 0.0F) / static_cast<float>(channels)
                          : *std::max_element(first, end);
    } else if (step.kind == StepKind::weigh) {
      const float factor = numbers[index_of(step.inputs[1])][i / channels];
      out[i] = in[i] / (1 + std::exp(-factor));
    }
  }
}

}  // namespace

void ExportProgram::run(std::vector<std::vector<float>>& numbers) const {
  for (const ExportStep& step : steps_) {
    std::vector<float>& out = numbers[index_of(step.value)];
    out.resize(index_of(value(step.value).size()));
    if (step.kind == StepKind::convolve) {
      convolve(*this, step, numbers);
    } else if (step.kind == StepKind::join) {
      auto to = out.begin();
      for (std::size_t pixel = 0; to != out.end(); ++pixel) {
        for (const int input : step.inputs) {
          const auto channels = static_cast<std::ptrdiff_t>(value(input).channels);
          to = std::copy_n(
              numbers[index_of(input)].begin() + static_cast<std::ptrdiff_t>(pixel) * channels,
              channels, to);
        }
      }
    } else if (step.kind != StepKind::sigmoid) {
      compute(*this, step, numbers);
    }
  }
}

std::vector<double> ExportProgram::ranges(const Frames& changes) const {
  std::vector<double> most(values_.size(), 0);
  std::vector<std::vector<float>> numbers(values_.size());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    numbers[0].resize(scale_.size());
    for (std::size_t c = 0; c < scale_.size(); ++c) {
      const auto change = static_cast<float>(changes(f, static_cast<Eigen::Index>(c)));
      numbers[0][c] = (change - shift_[c]) * scale_[c];
    }
    run(numbers);
    for (std::size_t v = 0; v < most.size(); ++v) {
      for (const float number : numbers[v]) {
        most[v] = std::max(most[v], std::abs(static_cast<double>(number)));
      }
    }
  }
  return most;
}

}  // namespace ertbench
