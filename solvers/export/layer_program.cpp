#include "solvers/export/layer_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/errors.h"

namespace ertbench {
namespace {

using StepKind = ExportStep::Kind;

/// [outputs][inputs][kernel][kernel] as [outputs][kernel][kernel][inputs], of the taps of a kernel
/// from first to last or from last to first.
std::vector<float> channels_last(const std::vector<float>& weights, std::size_t inputs,
                                 std::size_t taps, bool turned) {
  std::vector<float> out(weights.size());
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const std::size_t tap = i % taps;
    const std::size_t input = i / taps % inputs;
    const std::size_t output = i / taps / inputs;
    out[(output * taps + (turned ? taps - 1 - tap : tap)) * inputs + input] = weights[i];
  }
  return out;
}

/// Repeats the last pair, with weights of zero, until the code can add four inputs in a row.
void pad_pairs(std::vector<ExportStep>& steps, std::vector<ExportProgram::Value>& values) {
  if (steps[0].kind != StepKind::sums_of_pairs) return;
  int& pairs = values[index_of(steps[0].value)].channels;
  const int more = (4 - pairs % 4) % 4;
  for (ExportStep& step : steps) {
    if (step.kind != StepKind::convolve || step.inputs[0] != steps[0].value) continue;
    std::vector<float> padded;
    for (auto row = step.weights.begin(); row != step.weights.end(); row += pairs) {
      padded.insert(padded.end(), row, row + pairs);
      padded.resize(padded.size() + index_of(more), 0.0F);
    }
    step.weights = std::move(padded);
  }
  std::vector<int>& indices = steps[0].indices;
  const std::array last = {indices.end()[-2], indices.end()[-1]};
  for (int i = 0; i < more; ++i) indices.insert(indices.end(), last.begin(), last.end());
  pairs += more;
}

}  // namespace

ExportProgram::ExportProgram(const LayerList& list)
    : standardised_(!list.scale.empty()), shift_(list.shift), scale_(list.scale), unit_(list.unit) {
  for (const Layer& layer : list.layers) {
    value_of_.resize(std::max(value_of_.size(), index_of(layer.value) + 1), -1);
    add(layer);
    if (!layer.slopes.empty()) add_slopes(layer);
  }
  output_ = value_of_[index_of(list.layers.back().value)];
  if (!standardised_) {
    shift_.clear();
    scale_.clear();
  }
  shift_.resize(index_of(value(0).size()), 0);
  scale_.resize(index_of(value(0).size()), 1);
  for (std::size_t s = 0; s + 1 < steps_.size(); ++s) {
    if (can_merge(steps_[s], steps_[s + 1])) merge(s);
  }
  pad_pairs(steps_, values_);
  place_values();
}

int ExportProgram::add_value(int channels, int rows, int columns) {
  values_.push_back({channels, rows, columns});
  doubled_.push_back(false);
  return static_cast<int>(values_.size()) - 1;
}

void ExportProgram::add(const Layer& layer) {
  int& made = value_of_[index_of(layer.value)];
  const auto from = [&](std::size_t i) { return value_of_[index_of(layer.inputs[i])]; };
  switch (layer.kind) {
    case Layer::Kind::input:
      made = add_value(layer.width, 1, 1);
      return;
    case Layer::Kind::means_of_pairs:
      made = add_value(layer.width, 1, 1);
      doubled_[index_of(made)] = true;
      steps_.push_back({.kind = StepKind::sums_of_pairs,
                        .inputs = {from(0)},
                        .value = made,
                        .indices = layer.indices});
      return;
    case Layer::Kind::dense:
      return add_dense(layer);
    case Layer::Kind::maps:
      return add_maps(layer);
    case Layer::Kind::convolution:
    case Layer::Kind::transposed_convolution: {
      const bool transposed = layer.kind == Layer::Kind::transposed_convolution;
      if (transposed && layer.stride > 1) return add_spread(layer);
      const auto taps = index_of(layer.kernel * layer.kernel);
      const std::size_t inputs = layer.weights.size() / layer.bias.size() / taps;
      return add_convolution(layer, channels_last(layer.weights, inputs, taps, transposed),
                             transposed ? layer.kernel - 1 - layer.padding : layer.padding);
    }
    case Layer::Kind::attention:
      return add_attention(layer);
    case Layer::Kind::shuffle:
      // What a shuffle adds can be added before it.
      if (layer.added >= 0) steps_.back().added = value_of_[index_of(layer.added)];
      made = add_value(1, layer.height, layer.width);
      steps_.push_back({.kind = StepKind::shuffle, .inputs = {from(0)}, .value = made});
      return;
    case Layer::Kind::sigmoid:
      steps_.push_back({.kind = StepKind::sigmoid, .inputs = {from(0)}, .value = from(0)});
      return;
    case Layer::Kind::gather:
      made = add_value(layer.width, 1, 1);
      steps_.push_back(
          {.kind = StepKind::gather, .inputs = {from(0)}, .value = made, .indices = layer.indices});
      return;
    case Layer::Kind::pool:
      made = add_value(layer.channels, layer.height, layer.width);
      steps_.push_back({.kind = StepKind::pool, .inputs = {from(0)}, .value = made});
      return;
    case Layer::Kind::mixture:
      made = add_value(layer.width, 1, 1);
      steps_.push_back({.kind = StepKind::mixture,
                        .inputs = {from(1), from(0)},
                        .value = made,
                        .outputs = layer.width,
                        .weights = layer.weights,
                        .bias = layer.bias});
      return;
  }
  throw InputError("has layers that are not exported; export another method");
}

void ExportProgram::add_slopes(const Layer& layer) {
  const int from = value_of_[index_of(layer.value)];
  const Value shape = value(from);
  const int made = add_value(shape.channels, shape.rows, shape.columns);
  value_of_[index_of(layer.value)] = made;
  steps_.push_back(
      {.kind = StepKind::prelu, .inputs = {from}, .value = made, .weights = layer.slopes});
}

void ExportProgram::add_dense(const Layer& layer) {
  const int from = value_of_[index_of(layer.inputs[0])];
  const int made = add_value(layer.width, 1, 1);
  value_of_[index_of(layer.value)] = made;
  ExportStep step{.inputs = {from},
                  .value = made,
                  .outputs = layer.width,
                  .relu = layer.relu,
                  .weights = layer.weights,
                  .bias = layer.bias};
  if (doubled_[index_of(from)]) {
    for (float& weight : step.weights) weight /= 2;
  }
  steps_.push_back(std::move(step));
}

/// The vector is written in the order of the maps, by the dense layer that makes it; one map is in
/// order.
void ExportProgram::add_maps(const Layer& layer) {
  const int made = value_of_[index_of(layer.inputs[0])];
  value_of_[index_of(layer.value)] = made;
  values_[index_of(made)] = {layer.channels, layer.height, layer.width};
  if (layer.channels == 1) return;
  ExportStep& dense = steps_.back();
  const std::size_t pixels = index_of(layer.height * layer.width);
  const std::size_t inputs = dense.weights.size() / dense.bias.size();
  ExportStep ordered = dense;
  for (std::size_t o = 0; o < dense.bias.size(); ++o) {
    const std::size_t to = o % pixels * index_of(layer.channels) + o / pixels;
    ordered.bias[to] = dense.bias[o];
    std::copy_n(dense.weights.begin() + static_cast<std::ptrdiff_t>(o * inputs), inputs,
                ordered.weights.begin() + static_cast<std::ptrdiff_t>(to * inputs));
  }
  dense = std::move(ordered);
}

void ExportProgram::add_convolution(const Layer& layer, std::vector<float> weights, int padding) {
  int from = value_of_[index_of(layer.inputs[0])];
  if (layer.inputs.size() > 1) {
    std::vector<int> joined;
    int channels = 0;
    for (const int input : layer.inputs) {
      joined.push_back(value_of_[index_of(input)]);
      channels += value(joined.back()).channels;
    }
    from = add_value(channels, value(joined[0]).rows, value(joined[0]).columns);
    steps_.push_back({.kind = StepKind::join, .inputs = joined, .value = from});
  }
  const int made = add_value(layer.channels, layer.height, layer.width);
  value_of_[index_of(layer.value)] = made;
  steps_.push_back({.inputs = {from},
                    .value = made,
                    .added = layer.added < 0 ? -1 : value_of_[index_of(layer.added)],
                    .outputs = layer.channels,
                    .kernel = layer.kernel,
                    .stride = layer.stride,
                    .padding = padding,
                    .relu = layer.relu,
                    .weights = std::move(weights),
                    .bias = layer.bias});
}

/// A transposed convolution whose windows do not overlap: one convolution for each tap.
void ExportProgram::add_spread(const Layer& layer) {
  if (layer.kernel != layer.stride || layer.padding != 0) {
    throw InputError("has a transposed convolution that overlaps, which is not exported");
  }
  const int from = value_of_[index_of(layer.inputs[0])];
  const int made = add_value(layer.channels, layer.height, layer.width);
  value_of_[index_of(layer.value)] = made;
  const std::size_t taps = index_of(layer.kernel * layer.kernel);
  for (std::size_t tap = 0; tap < taps; ++tap) {
    ExportStep step{.inputs = {from},
                    .value = made,
                    .added = layer.added < 0 ? -1 : value_of_[index_of(layer.added)],
                    .outputs = layer.channels,
                    .spread = layer.stride,
                    .row = static_cast<int>(tap) / layer.kernel,
                    .column = static_cast<int>(tap) % layer.kernel,
                    .relu = layer.relu,
                    .bias = layer.bias};
    for (std::size_t i = tap; i < layer.weights.size(); i += taps) {
      step.weights.push_back(layer.weights[i]);
    }
    steps_.push_back(std::move(step));
  }
}

void ExportProgram::add_attention(const Layer& layer) {
  const int from = value_of_[index_of(layer.inputs[0])];
  const int summary = add_value(2, layer.height, layer.width);
  const int factors = add_value(1, layer.height, layer.width);
  const int made = add_value(layer.channels, layer.height, layer.width);
  value_of_[index_of(layer.value)] = made;
  steps_.push_back({.kind = StepKind::summarise, .inputs = {from}, .value = summary});
  steps_.push_back(
      {.inputs = {summary},
       .value = factors,
       .outputs = 1,
       .kernel = layer.kernel,
       .padding = layer.kernel / 2,
       .weights = channels_last(layer.weights, 2, index_of(layer.kernel * layer.kernel), false),
       .bias = {0}});
  steps_.push_back({.kind = StepKind::sigmoid, .inputs = {factors}, .value = factors});
  steps_.push_back({.kind = StepKind::weigh, .inputs = {from, factors}, .value = made});
}

/// True if a convolution alone reads a dense layer's numbers, as they are, and makes no more of
/// them.
bool ExportProgram::can_merge(const ExportStep& dense, const ExportStep& next) const {
  if (dense.kind != StepKind::convolve || next.kind != StepKind::convolve) return false;
  const auto reads = [&](const ExportStep& step) {
    return step.added == dense.value ||
           std::count(step.inputs.begin(), step.inputs.end(), dense.value);
  };
  return value(dense.inputs[0]).pixels() == 1 && !dense.relu && dense.added < 0 &&
         next.kernel > 1 && next.spread == 1 && next.inputs[0] == dense.value &&
         std::count_if(steps_.begin(), steps_.end(), reads) == 1 &&
         value(next.value).size() <= dense.outputs;
}

/// Replaces a dense layer and the convolution after it by the one dense layer that both are.
void ExportProgram::merge(std::size_t index) {
  const ExportStep dense = steps_[index];
  ExportStep linear = steps_[index + 1];
  const Value& maps = value(dense.value);
  const int columns = sum_columns(linear);
  const int outputs = value(linear.value).size();
  const std::size_t inputs = dense.weights.size() / dense.bias.size();
  const auto convolved = [&](const std::vector<float>& numbers) {
    std::vector<float> out;
    for (int i = 0; i < outputs; ++i) {
      const int pixel = i / linear.outputs;
      out.push_back(
          window_sum(linear, maps, numbers, i % linear.outputs, pixel / columns, pixel % columns));
    }
    return out;
  };
  ExportStep both = {.inputs = dense.inputs,
                     .value = linear.value,
                     .added = linear.added,
                     .outputs = outputs,
                     .relu = linear.relu,
                     .weights = std::vector<float>(index_of(outputs) * inputs),
                     .bias = convolved(dense.bias)};
  std::fill(linear.bias.begin(), linear.bias.end(), 0.0F);
  std::vector<float> column(dense.bias.size());
  for (std::size_t i = 0; i < inputs; ++i) {
    for (std::size_t o = 0; o < column.size(); ++o) column[o] = dense.weights[o * inputs + i];
    const std::vector<float> out = convolved(column);
    for (std::size_t o = 0; o < out.size(); ++o) both.weights[o * inputs + i] = out[o];
  }
  steps_[index] = both;
  steps_.erase(steps_.begin() + static_cast<std::ptrdiff_t>(index) + 1);
}

int ExportProgram::sum_rows(const ExportStep& step) const {
  return (value(step.inputs[0]).rows + 2 * step.padding - step.kernel) / step.stride + 1;
}

int ExportProgram::sum_columns(const ExportStep& step) const {
  return (value(step.inputs[0]).columns + 2 * step.padding - step.kernel) / step.stride + 1;
}

/// Values that are not needed at the same time share memory. The input stands at its beginning.
void ExportProgram::place_values() {
  const std::size_t count = values_.size();
  std::vector<int> born(count, static_cast<int>(steps_.size()));
  std::vector<int> last(count, 0);
  const auto use = [&](int used, int when) {
    if (used < 0) return;
    born[index_of(used)] = std::min(born[index_of(used)], when);
    last[index_of(used)] = std::max(last[index_of(used)], when);
  };
  use(0, -1);
  for (std::size_t s = 0; s < steps_.size(); ++s) {
    for (const int input : steps_[s].inputs) use(input, static_cast<int>(s));
    use(steps_[s].added, static_cast<int>(s));
    use(steps_[s].value, static_cast<int>(s));
  }
  use(output_, static_cast<int>(steps_.size()));
  for (std::size_t v = 0; v < count; ++v) {
    if (last[v] < born[v]) continue;  // of a layer that is merged
    int place = 0;
    for (bool moved = true; moved;) {
      moved = false;
      for (std::size_t w = 0; w < v; ++w) {
        const Value& other = values_[w];
        if (last[w] < born[v] || last[v] < born[w]) continue;
        if (place >= other.place + other.size() || other.place >= place + values_[v].size()) {
          continue;
        }
        place = other.place + other.size();
        moved = true;
      }
    }
    values_[v].place = place;
    memory_ = std::max(memory_, place + values_[v].size());
  }
}

void ExportProgram::equalise_input(const Frames& changes) {
  if (standardised_ || steps_[0].kind != StepKind::sums_of_pairs) return;
  const Eigen::RowVectorXd squares = changes.colwise().squaredNorm() / changes.rows();
  const double mean = squares.mean();
  std::vector<float>& weights = steps_[1].weights;
  const std::size_t pairs = steps_[0].indices.size() / 2;
  for (std::size_t p = 0; p < pairs; ++p) {
    const int a = steps_[0].indices[2 * p];
    const int b = steps_[0].indices[2 * p + 1];
    const double square = (squares[a] + squares[b]) / 2;
    const auto size = static_cast<float>(std::sqrt(std::max(square, 1e-12 * mean)));
    if (!(size > 0)) continue;
    scale_[index_of(a)] = scale_[index_of(b)] = 1 / size;
    for (std::size_t i = p; i < weights.size(); i += pairs) weights[i] *= size;
  }
}

}  // namespace ertbench
