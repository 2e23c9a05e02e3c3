#include "models/training/checkpoint.h"

#include <torch/nn/modules/batchnorm.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"
#include "models/networks/tensor_file.h"

namespace ertbench {

namespace nn = torch::nn;

std::vector<Adam::Group> parameter_groups(const Network& network) {
  const std::vector<torch::Tensor> slow = network.slow_parameters();
  Adam::Group others;
  for (const torch::Tensor& parameter : network.parameters()) {
    const auto same = [&](const torch::Tensor& one) { return one.is_same(parameter); };
    if (std::none_of(slow.begin(), slow.end(), same)) others.push_back(parameter);
  }
  return {others, slow};
}

void freeze_statistics(Network& network) {
  for (const auto& module : network.modules()) {
    if (module->as<nn::BatchNorm1dImpl>() || module->as<nn::BatchNorm2dImpl>()) {
      module->eval();
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
