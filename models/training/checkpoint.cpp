#include "models/training/checkpoint.h"

#include <c10/util/string_utils.h>
#include <torch/nn/modules/batchnorm.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"
#include "models/networks/tensor_file.h"

namespace ertbench {

namespace nn = torch::nn;

std::vector<torch::optim::OptimizerParamGroup> parameter_groups(const Network& network) {
  const std::vector<torch::Tensor> slow = network.slow_parameters();
  std::vector<torch::Tensor> others;
  for (const torch::Tensor& parameter : network.parameters()) {
    const auto same = [&](const torch::Tensor& one) { return one.is_same(parameter); };
    if (std::none_of(slow.begin(), slow.end(), same)) others.push_back(parameter);
  }
  return {torch::optim::OptimizerParamGroup(others), torch::optim::OptimizerParamGroup(slow)};
}

void freeze_statistics(Network& network) {
  for (const auto& module : network.modules()) {
    if (module->as<nn::BatchNorm1dImpl>() || module->as<nn::BatchNorm2dImpl>()) {
      module->eval();
    }
  }
}

namespace {

using torch::optim::AdamParamState;

/// The name that the optimiser's own map has for a parameter.
std::string key_in_optimiser(const torch::Tensor& parameter) {
  return c10::guts::to_string(parameter.unsafeGetTensorImpl());
}

}  // namespace

NamedTensors state_of(const torch::optim::Adam& optimiser) {
  NamedTensors out;
  std::size_t number = 0;
  for (const auto& group : optimiser.param_groups()) {
    for (const torch::Tensor& parameter : group.params()) {
      std::int64_t steps = 0;
      torch::Tensor mean = torch::zeros_like(parameter);
      torch::Tensor mean_square = torch::zeros_like(parameter);
      const auto found = optimiser.state().find(key_in_optimiser(parameter));
      if (found != optimiser.state().end()) {
        const auto& state = static_cast<const AdamParamState&>(*found->second);
        steps = state.step();
        mean = state.exp_avg().detach().clone();
        mean_square = state.exp_avg_sq().detach().clone();
      }
      const std::string prefix = std::to_string(number++) + ".";
      out.push_back({prefix + "steps", torch::tensor(steps, torch::kInt64)});
      out.push_back({prefix + "mean", mean});
      out.push_back({prefix + "mean_square", mean_square});
    }
  }
  return out;
}

void set_state(torch::optim::Adam& optimiser, const NamedTensors& state) {
  std::size_t next = 0;
  for (const auto& group : optimiser.param_groups()) {
    for (const torch::Tensor& parameter : group.params()) {
      auto of_parameter = std::make_unique<AdamParamState>();
      of_parameter->step(state.at(next++).values.item<std::int64_t>());
      of_parameter->exp_avg(state.at(next++).values.clone());
      of_parameter->exp_avg_sq(state.at(next++).values.clone());
      optimiser.state()[key_in_optimiser(parameter)] = std::move(of_parameter);
    }
  }
}

namespace {

/// Result of a training with at least one finished epoch.
TrainingResult read_result(const Hdf5File& file) {
  TrainingResult result;
  try {
    result = training_result_from_json(
        parse_json(file.read_text("/", "result"), file.path().string() + ": attribute result"));
  } catch (const nlohmann::json::exception&) {
    result = {};
  }
  if (result.best_epoch < 1 || result.best_epoch > result.epochs) {
    throw InputError(file.path().string() + ": attribute result: is not of a training under way");
  }
  return result;
}

}  // namespace

void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  Hdf5File out = Hdf5File::create(file);
  out.write_text("/", "result", to_json(checkpoint.result).dump());
  out.write_matrix("/log", checkpoint.log);
  write_tensors(out, "/network", checkpoint.network);
  write_tensors(out, "/best", checkpoint.best);
  write_tensors(out, "/optimiser", checkpoint.optimiser);
  write_tensors(out, "/objective", checkpoint.objective);
  out.write_checksum();
  out.close();
}

Checkpoint read_checkpoint(const std::filesystem::path& file, const Checkpoint& like) {
  const Hdf5File in = Hdf5File::open(file);
  if (const std::string why = in.why_changed(); !why.empty()) {
    throw InputError(file.string() + ": " + why);
  }
  Checkpoint out;
  out.result = read_result(in);
  const auto rows = static_cast<std::uint64_t>(out.result.epochs);
  in.require_shape("/log", {rows, static_cast<std::uint64_t>(like.log.cols())});
  out.log = in.read_rows("/log", 0, rows, true);
  out.network = read_tensors(in, "/network", like.network);
  out.best = read_tensors(in, "/best", like.best);
  out.optimiser = read_tensors(in, "/optimiser", like.optimiser);
  out.objective = read_tensors(in, "/objective", like.objective);
  return out;
}

}  // namespace ertbench
