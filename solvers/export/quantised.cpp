#include "solvers/export/quantised.h"

#include <algorithm>
#include <cmath>

namespace ertbench {
namespace {

using StepKind = ExportStep::Kind;

constexpr double most_weight = 127;
constexpr double most_count = 32767;
constexpr double most_sum = 2147483647.0 * 0.99;  ///< room for what is rounded
constexpr double factor_unit = 4294967296.0;      ///< 2^32
constexpr double most_factor = 0.25;              ///< so that products stay below 2^62

/// Steps of the weights of each output.
std::vector<double> weight_steps(const ExportStep& step) {
  const std::size_t size = step.weights.size() / step.bias.size();
  std::vector<double> out;
  for (std::size_t o = 0; o < step.bias.size(); ++o) {
    double most = 0;
    for (std::size_t i = 0; i < size; ++i) {
      most = std::max(most, std::abs(static_cast<double>(step.weights[o * size + i])));
    }
    out.push_back(most > 0 ? most / most_weight : 1);
  }
  return out;
}

/// Largest count of the input with which no sum overflows. Bias and added counts grow with it.
double input_limit(const ExportStep& step, const std::vector<double>& weight_step,
                   const std::vector<double>& ranges) {
  const std::size_t size = step.weights.size() / step.bias.size();
  const double range = ranges[index_of(step.inputs[0])];
  double largest = 1;
  for (std::size_t o = 0; o < step.bias.size(); ++o) {
    const double added = step.added < 0 ? 0 : ranges[index_of(step.added)];
    double sum = (std::abs(static_cast<double>(step.bias[o])) + added) / (range * weight_step[o]);
    for (std::size_t i = 0; i < size; ++i) {
      sum += std::abs(std::round(step.weights[o * size + i] / weight_step[o]));
    }
    largest = std::max(largest, sum);
  }
  return std::min(most_count, std::floor(most_sum / largest));
}

QuantisedProgram::Step quantised_step(const ExportStep& step,
                                      const std::vector<double>& weight_step,
                                      const std::vector<QuantisedProgram::Value>& values) {
  const std::size_t size = step.weights.size() / step.bias.size();
  const double in = values[index_of(step.inputs[0])].step;
  QuantisedProgram::Step out;
  for (std::size_t o = 0; o < step.bias.size(); ++o) {
    const double unit = in * weight_step[o];
    for (std::size_t i = 0; i < size; ++i) {
      const double weight = std::round(step.weights[o * size + i] / weight_step[o]);
      out.weights.push_back(static_cast<std::int8_t>(weight));
    }
    out.bias.push_back(static_cast<std::int32_t>(std::round(step.bias[o] / unit)));
    out.factors.push_back(static_cast<std::int32_t>(
        std::round(unit / values[index_of(step.value)].step * factor_unit)));
    if (step.added < 0) continue;
    out.added.push_back(
        static_cast<std::int32_t>(std::round(values[index_of(step.added)].step / unit)));
  }
  return out;
}

/// Steps whose output has the scale of their input.
bool keeps_scale(const ExportStep& step) {
  return step.kind != StepKind::convolve && step.kind != StepKind::join &&
         step.kind != StepKind::sums_of_pairs && step.kind != StepKind::sigmoid;
}

std::vector<std::int32_t> in_65536ths(const std::vector<double>& numbers) {
  std::vector<std::int32_t> out;
  for (const double one : numbers) {
    out.push_back(static_cast<std::int32_t>(std::round(65536 * std::clamp(one, -1e4, 1e4))));
  }
  return out;
}

/// In the order of the steps, because a step of an output depends on that of its input.
void settle_scales(const std::vector<ExportStep>& steps,
                   const std::vector<std::vector<double>>& weight_step,
                   std::vector<QuantisedProgram::Value>& values) {
  for (std::size_t s = 0; s < steps.size(); ++s) {
    QuantisedProgram::Value& in = values[index_of(steps[s].inputs[0])];
    QuantisedProgram::Value& out = values[index_of(steps[s].value)];
    if (steps[s].kind == StepKind::sums_of_pairs) {
      in = {out.step, out.most / 2};
    } else if (steps[s].kind == StepKind::gather) {
      in = out;
    } else if (steps[s].kind == StepKind::join) {
      out = in;
      for (const int input : steps[s].inputs) {
        out.step = std::max(out.step, values[index_of(input)].step);
      }
    } else if (keeps_scale(steps[s])) {
      out = in;
    } else if (steps[s].kind == StepKind::convolve) {
      const double largest = *std::max_element(weight_step[s].begin(), weight_step[s].end());
      out.step = std::max(out.step, in.step * largest / most_factor);
    }
  }
}

}  // namespace

QuantisedProgram quantise(const ExportProgram& program, std::vector<double> ranges) {
  const std::vector<ExportStep>& steps = program.steps();
  for (double& range : ranges) range = range > 0 ? range : 1;
  std::vector<double> limits(ranges.size(), most_count);
  std::vector<std::vector<double>> weight_step(steps.size());
  for (std::size_t s = 0; s < steps.size(); ++s) {
    const std::size_t in = index_of(steps[s].inputs[0]);
    const std::size_t out = index_of(steps[s].value);
    if (steps[s].kind == StepKind::sums_of_pairs) ranges[out] = 2 * ranges[in];
    if (keeps_scale(steps[s])) ranges[in] = ranges[out] = std::max(ranges[in], ranges[out]);
    if (steps[s].kind != StepKind::convolve) continue;
    weight_step[s] = weight_steps(steps[s]);
    limits[in] = std::min(limits[in], input_limit(steps[s], weight_step[s], ranges));
  }
  for (auto step = steps.rbegin(); step != steps.rend(); ++step) {
    if (!keeps_scale(*step) && step->kind != StepKind::join) continue;
    for (const int in : step->inputs) {
      limits[index_of(in)] = std::min(limits[index_of(in)], limits[index_of(step->value)]);
    }
  }
  // All layers write numbers of the same bits, to which an instruction can limit them.
  QuantisedProgram result;
  result.bits = 15;
  for (const ExportStep& step : steps) {
    if (step.kind != StepKind::convolve) continue;
    while ((1 << result.bits) - 1 > limits[index_of(step.value)]) --result.bits;
  }
  for (const ExportStep& step : steps) {
    if (step.kind == StepKind::convolve) limits[index_of(step.value)] = (1 << result.bits) - 1;
  }
  for (std::size_t v = 0; v < ranges.size(); ++v) {
    result.values.push_back({ranges[v] / limits[v], static_cast<int>(limits[v])});
  }
  settle_scales(steps, weight_step, result.values);
  for (std::size_t s = 0; s < steps.size(); ++s) {
    QuantisedProgram::Step& made = result.steps.emplace_back();
    if (steps[s].kind == StepKind::convolve) {
      made = quantised_step(steps[s], weight_step[s], result.values);
    } else if (steps[s].kind == StepKind::prelu) {
      made.factors = in_65536ths({steps[s].weights.begin(), steps[s].weights.end()});
    } else if (steps[s].kind == StepKind::join) {
      std::vector<double> ratios;
      for (const int input : steps[s].inputs) {
        ratios.push_back(result.values[index_of(input)].step /
                         result.values[index_of(steps[s].value)].step);
      }
      made.factors = in_65536ths(ratios);
    }
  }
  return result;
}

}  // namespace ertbench
