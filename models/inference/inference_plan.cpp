#include "models/inference/inference_plan.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <utility>

#include "models/inference/convolution_step.h"
#include "models/inference/map_steps.h"

namespace ertbench {

/// Zero at first; borders and unused lanes stay zero.
class InferencePlan::Workspace {
 public:
  explicit Workspace(std::ptrdiff_t size)
      : numbers_(static_cast<float*>(std::aligned_alloc(64, bytes_of(size)))) {
    if (!numbers_) throw std::bad_alloc();
    std::fill_n(numbers_.get(), bytes_of(size) / sizeof(float), 0.0F);
  }
  float* numbers() const { return numbers_.get(); }

 private:
  struct Free {
    void operator()(float* numbers) const { std::free(numbers); }
  };
  static std::size_t bytes_of(std::ptrdiff_t size) {
    return (static_cast<std::size_t>(size) * sizeof(float) + 63) / 64 * 64;
  }

  std::unique_ptr<float, Free> numbers_;
};

InferencePlan::InferencePlan(std::vector<std::unique_ptr<PlanStep>> steps, const MapLayout& input,
                             const MapLayout& output, std::ptrdiff_t workspace)
    : steps_(std::move(steps)), input_(input), output_(output), size_(workspace) {
  free_.push_back(std::make_unique<Workspace>(size_));
}

InferencePlan::~InferencePlan() = default;

std::unique_ptr<InferencePlan::Workspace> InferencePlan::take() const {
  {
    const std::lock_guard lock(mutex_);
    if (!free_.empty()) {
      std::unique_ptr<Workspace> workspace = std::move(free_.back());
      free_.pop_back();
      return workspace;
    }
  }
  return std::make_unique<Workspace>(size_);
}

void InferencePlan::give_back(std::unique_ptr<Workspace> workspace) const {
  const std::lock_guard lock(mutex_);
  free_.push_back(std::move(workspace));
}

void InferencePlan::run(const float* input, float* output) const {
  std::unique_ptr<Workspace> workspace = take();
  float* const numbers = workspace->numbers();
  std::copy_n(input, input_.width, numbers + input_.channel(0));
  for (const auto& step : steps_) step->run(numbers);
  for (int channel = 0; channel < output_.channels; ++channel) {
    const float* row = numbers + output_.channel(channel);
    for (int y = 0; y < output_.height; ++y, row += output_.row(), output += output_.width) {
      std::copy_n(row, output_.width, output);
    }
  }
  give_back(std::move(workspace));
}

namespace {

constexpr std::ptrdiff_t line = 64 / sizeof(float);  ///< a cache line

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("the plan of a network: ") + what);
}

int side(int length, const ConvolutionWeights& weights) {
  return (length + 2 * weights.padding - weights.kernel) / weights.stride + 1;
}

/// The weights of one tap as a convolution of its own.
ConvolutionWeights tap_of(const ConvolutionWeights& all, int tap) {
  ConvolutionWeights out;
  out.inputs = all.inputs;
  out.outputs = all.outputs;
  out.kernel = 1;
  out.bias = all.bias;
  const int taps = all.kernel * all.kernel;
  for (int i = 0; i < all.outputs * all.inputs; ++i) {
    out.weights.push_back(all.weights[static_cast<std::size_t>(i * taps + tap)]);
  }
  return out;
}

}  // namespace

ConvolutionWeights turned(ConvolutionWeights weights) {
  const auto taps = static_cast<std::ptrdiff_t>(weights.kernel) * weights.kernel;
  for (auto at = weights.weights.begin(); at != weights.weights.end(); at += taps) {
    std::reverse(at, at + taps);
  }
  weights.padding = weights.kernel - 1 - weights.padding;
  return weights;
}

int PlanBuilder::add(const MapLayout& layout) {
  values_.push_back(layout);
  return static_cast<int>(values_.size()) - 1;
}

void PlanBuilder::widen_border(int value, int border) {
  int& now = values_[static_cast<std::size_t>(value)].border;
  now = std::max(now, border);
}

template <typename Step, typename... Arguments>
void PlanBuilder::step(Arguments&&... arguments) {
  steps_.push_back(std::make_unique<Step>(std::forward<Arguments>(arguments)...));
}

void PlanBuilder::record(Layer layer, int value) {
  if (!recorded_) return;
  layer.value = value;
  layer.channels = layout(value).channels;
  layer.height = layout(value).height;
  layer.width = layout(value).width;
  recorded_->push_back(std::move(layer));
}

Layer PlanBuilder::layer_of(Layer::Kind kind, std::vector<int> inputs,
                            const ConvolutionWeights& weights, const Activation& activation,
                            int added) const {
  if (!recorded_) return {};
  return {.kind = kind,
          .inputs = std::move(inputs),
          .added = added,
          .kernel = weights.kernel,
          .stride = weights.stride,
          .padding = weights.padding,
          .relu = activation.kind == Activation::Kind::relu,
          .weights = weights.weights,
          .bias = weights.bias,
          .slopes = activation.slopes};
}

int PlanBuilder::input(int size) {
  require(values_.empty(), "the input comes first");
  const int out = vector(size);
  record({}, out);
  return out;
}

int PlanBuilder::dense(int from, DenseWeights weights, const Activation& activation) {
  require(layout(from).width == weights.inputs && layout(from).height == 1,
          "sizes of a dense layer");
  const int out = vector(weights.outputs);
  record({.kind = Layer::Kind::dense,
          .inputs = {from},
          .relu = activation.kind == Activation::Kind::relu,
          .weights = recorded_ ? weights.weights : std::vector<float>(),
          .bias = weights.bias},
         out);
  step<MapStep>(std::vector{from, out}, multiply_dense(weights, activation.kind, bfloat16_));
  return out;
}

int PlanBuilder::gather(int from, std::vector<int> sources) {
  const int out = vector(static_cast<int>(sources.size()));
  record({.kind = Layer::Kind::gather, .inputs = {from}, .indices = sources}, out);
  step<MapStep>(std::vector{from, out}, gather_numbers(std::move(sources)));
  return out;
}

int PlanBuilder::means_of_pairs(int from, std::vector<int> pairs) {
  const int out = vector(static_cast<int>(pairs.size() / 2));
  record({.kind = Layer::Kind::means_of_pairs, .inputs = {from}, .indices = pairs}, out);
  step<MapStep>(std::vector{from, out}, mean_pairs(std::move(pairs)));
  return out;
}

int PlanBuilder::maps(int from, int channels, int height, int width) {
  require(layout(from).width == channels * height * width, "maps of a vector");
  const int out = add({.channels = channels, .height = height, .width = width, .planar = true});
  record({.kind = Layer::Kind::maps, .inputs = {from}}, out);
  step<MapStep>(std::vector{from, out}, lay_maps);
  return out;
}

int PlanBuilder::convolution(std::vector<int> inputs, ConvolutionWeights weights,
                             const Activation& activation, int added) {
  int channels = 0;
  for (const int input : inputs) {
    channels += layout(input).channels;
    widen_border(input, weights.padding);
  }
  require(channels == weights.inputs, "channels of a convolution");
  const MapLayout& from = layout(inputs.front());
  const int out = add({.channels = weights.outputs,
                       .height = side(from.height, weights),
                       .width = side(from.width, weights)});
  record(layer_of(Layer::Kind::convolution, inputs, weights, activation, added), out);
  alike_.push_back(inputs);
  step<ConvolutionStep>(std::move(inputs), out, std::move(weights), activation, added,
                        OutputPixels{});
  return out;
}

int PlanBuilder::image_convolution(int from, ConvolutionWeights weights) {
  require(!layout(from).planar && weights.stride == 1 &&
              weights.outputs <= NarrowConvolutionStep::most_outputs &&
              weights.inputs == layout(from).channels,
          "a convolution to an image");
  widen_border(from, weights.padding);
  const int out = add({.channels = weights.outputs,
                       .height = side(layout(from).height, weights),
                       .width = side(layout(from).width, weights),
                       .planar = true});
  record(layer_of(Layer::Kind::convolution, {from}, weights, {}, none), out);
  step<NarrowConvolutionStep>(from, out, std::move(weights));
  return out;
}

int PlanBuilder::transposed_convolution(int from, ConvolutionWeights weights,
                                        const Activation& activation, int added) {
  if (weights.stride == 1 && weights.padding > 0) {
    return convolution({from}, turned(std::move(weights)), activation, added);
  }
  require(weights.padding == 0, "padding of a transposed convolution with a stride");
  const bool overlapping = weights.kernel > weights.stride;
  require(!overlapping || activation.kind == Activation::Kind::none,
          "activation of an overlapping transposed convolution");
  require(weights.kernel >= weights.stride, "gaps of a transposed convolution");
  const MapLayout& small = layout(from);
  const int out = add({.channels = weights.outputs,
                       .height = (small.height - 1) * weights.stride + weights.kernel,
                       .width = (small.width - 1) * weights.stride + weights.kernel});
  record(layer_of(Layer::Kind::transposed_convolution, {from}, weights, activation, added), out);
  if (overlapping) {
    std::vector<float> bias = weights.bias;
    bias.resize(static_cast<std::size_t>(layout(out).blocks() * lanes));
    step<MapStep>(std::vector{out, added}, fill_maps(std::move(bias)));
  }
  for (int tap = 0; tap < weights.kernel * weights.kernel; ++tap) {
    const OutputPixels pixels{.step = weights.stride,
                              .first_row = tap / weights.kernel,
                              .first_column = tap % weights.kernel,
                              .accumulate = overlapping};
    step<ConvolutionStep>(std::vector{from}, out, tap_of(weights, tap), activation,
                          overlapping ? none : added, pixels);
  }
  return out;
}

int PlanBuilder::pool(int from) {
  const MapLayout& large = layout(from);
  require(!large.planar, "pooling of planar maps");
  const int out =
      add({.channels = large.channels, .height = large.height / 2, .width = large.width / 2});
  record({.kind = Layer::Kind::pool, .inputs = {from}}, out);
  step<MapStep>(std::vector{from, out}, pool_maps);
  return out;
}

int PlanBuilder::attention(int from, int kernel, std::vector<float> weights) {
  require(!layout(from).planar, "attention on planar maps");
  MapLayout summary = layout(from);
  summary.channels = 2;
  summary.planar = true;
  summary.border = kernel / 2;
  const int between = add(summary);
  MapLayout same = layout(from);
  same.border = 0;
  const int out = add(same);
  record({.kind = Layer::Kind::attention, .inputs = {from}, .kernel = kernel, .weights = weights},
         out);
  step<MapStep>(std::vector{from, between, out}, attend_maps(kernel, std::move(weights)));
  return out;
}

int PlanBuilder::shuffle(int from, int added) {
  const MapLayout& maps = layout(from);
  require(maps.planar && maps.channels == 4 && (added == none || layout(added).planar),
          "maps that are shuffled");
  const int out = add({.height = 2 * maps.height, .width = 2 * maps.width, .planar = true});
  record({.kind = Layer::Kind::shuffle, .inputs = {from}, .added = added}, out);
  step<MapStep>(std::vector{from, out, added}, shuffle_maps);
  return out;
}

int PlanBuilder::sigmoid(int maps) {
  require(layout(maps).planar, "a sigmoid of blocked maps");
  record({.kind = Layer::Kind::sigmoid, .inputs = {maps}}, maps);
  step<MapStep>(std::vector{maps}, sigmoid_maps);
  return maps;
}

int PlanBuilder::mixture(int whitened, int from, DenseWeights estimates) {
  const auto outputs = static_cast<std::size_t>(estimates.outputs);
  const auto components = estimates.bias.size() / (outputs + 1);
  require(components > 0 && estimates.bias.size() == components * (outputs + 1) &&
              estimates.weights.size() ==
                  components * outputs * static_cast<std::size_t>(estimates.inputs) &&
              layout(from).width == estimates.inputs &&
              static_cast<std::size_t>(layout(whitened).width) % components == 0,
          "sizes of a mixture");
  const int out = vector(estimates.outputs);
  record({.kind = Layer::Kind::mixture,
          .inputs = {whitened, from},
          .weights = recorded_ ? estimates.weights : std::vector<float>(),
          .bias = estimates.bias},
         out);
  step<MapStep>(std::vector{whitened, from, out}, average_mixture(std::move(estimates)));
  return out;
}

std::unique_ptr<InferencePlan> PlanBuilder::finish(int output) {
  require(layout(output).planar, "its output is not planar");
  for (bool changed = true; changed;) {
    changed = false;
    for (const std::vector<int>& alike : alike_) {
      int widest = 0;
      for (const int value : alike) widest = std::max(widest, layout(value).border);
      for (const int value : alike) {
        changed = changed || layout(value).border != widest;
        widen_border(value, widest);
      }
    }
  }
  std::ptrdiff_t size = 0;
  for (MapLayout& value : values_) {
    value.offset = size;
    // A line of room behind each: kernels may read past a row's end, and vectors are written whole.
    size += (value.size() + 2 * line - 1) / line * line + line;
  }
  for (const auto& step : steps_) step->prepare(values_);
  return std::make_unique<InferencePlan>(std::move(steps_), values_.front(), layout(output), size);
}

}  // namespace ertbench
