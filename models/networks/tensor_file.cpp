#include "models/networks/tensor_file.h"

#include <torch/csrc/jit/frontend/tracer.h>
#include <torch/csrc/jit/passes/constant_propagation.h>
#include <torch/csrc/jit/passes/dead_code_elimination.h>
#include <torch/csrc/jit/passes/frozen_graph_optimizations.h>
#include <torch/csrc/jit/passes/frozen_ops_to_mkldnn.h>
#include <torch/csrc/jit/passes/graph_rewrite_helper.h>
#include <torch/csrc/jit/runtime/graph_executor.h>
#include <torch/nn/module.h>
#include <torch/utils.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/errors.h"
#include "models/networks/dense_networks.h"

namespace ertbench {

NamedTensors weights_of(const torch::nn::Module& module) {
  NamedTensors weights;
  for (const auto& item : module.named_parameters()) weights.push_back({item.key(), item.value()});
  for (const auto& item : module.named_buffers()) weights.push_back({item.key(), item.value()});
  return weights;
}

torch::Tensor tensor_of(const FloatRows& matrix) {
  return torch::from_blob(const_cast<float*>(matrix.data()), {matrix.rows(), matrix.cols()})
      .clone();
}

NamedTensors copies(const NamedTensors& tensors) {
  NamedTensors out;
  for (const auto& [name, values] : tensors) out.push_back({name, values.detach().clone()});
  return out;
}

void copy_values(const NamedTensors& from, const NamedTensors& to) {
  const torch::NoGradGuard no_gradients;
  for (std::size_t i = 0; i < to.size(); ++i) {
    torch::Tensor target = to[i].values;
    target.copy_(from.at(i).values);
  }
}

void append(NamedTensors& all, const std::string& prefix, const NamedTensors& tensors) {
  for (const auto& [name, values] : tensors) all.push_back({prefix + name, values});
}

namespace {

Hdf5File::Number number_of(const torch::Tensor& tensor) {
  if (tensor.dtype() == torch::kFloat32) return Hdf5File::Number::real32;
  if (tensor.dtype() == torch::kInt64) return Hdf5File::Number::int64;
  throw std::logic_error("a tensor to be saved is neither of 32-bit reals nor of 64-bit integers");
}

std::vector<std::uint64_t> shape_of(const torch::Tensor& tensor) {
  if (tensor.dim() == 0) return {1};
  return {tensor.sizes().begin(), tensor.sizes().end()};
}

}  // namespace

void write_tensor(Hdf5File& file, const std::string& dataset, const torch::Tensor& values) {
  const std::vector<std::uint64_t> shape = shape_of(values);
  file.create_dataset(dataset, shape, number_of(values));
  const torch::Tensor wide = values.detach().cpu().to(torch::kFloat64).contiguous();
  const auto rows = static_cast<Eigen::Index>(shape[0]);
  file.write_rows(dataset, 0,
                  Eigen::Map<const RowMajorMatrix>(wide.data_ptr<double>(), rows,
                                                   static_cast<Eigen::Index>(wide.numel()) / rows));
}

torch::Tensor read_tensor(const Hdf5File& file, const std::string& dataset,
                          const torch::Tensor& like) {
  const std::vector<std::uint64_t> shape = shape_of(like);
  file.require_number(dataset, number_of(like));
  file.require_shape(dataset, shape);
  const RowMajorMatrix values = file.read_rows(dataset, 0, shape[0], true);
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values.data()[i])) continue;
    throw InputError(file.path().string() + ": " + dataset + ": element " + std::to_string(i) +
                     " is not a finite number");
  }
  return torch::from_blob(const_cast<double*>(values.data()), like.sizes(), torch::kFloat64)
      .to(like.dtype(), false, true);
}

void write_tensors(Hdf5File& file, const std::string& group, const NamedTensors& tensors) {
  for (const auto& [name, values] : tensors) write_tensor(file, group + "/" + name, values);
}

NamedTensors read_tensors(const Hdf5File& file, const std::string& group,
                          const NamedTensors& like) {
  for (const std::string& found : file.names(group)) {
    const auto same = [&](const NamedTensor& one) { return one.name == found; };
    if (std::any_of(like.begin(), like.end(), same)) continue;
    throw InputError(file.path().string() + ": " + group + "/" + found +
                     ": has no place in the network");
  }
  NamedTensors out;
  for (const auto& [name, values] : like) {
    out.push_back({name, read_tensor(file, group + "/" + name, values)});
  }
  return out;
}

namespace jit = torch::jit;

namespace {

std::unique_ptr<jit::GraphExecutor> executor_of(std::shared_ptr<jit::Graph> graph) {
  jit::OptimizeFrozenGraph(graph);
  jit::ConvertFrozenOpsToMKLDNN(graph);
  jit::EliminateDeadCode(graph);
  return std::make_unique<jit::GraphExecutor>(graph, "network");
}

}  // namespace

FrozenGraph::FrozenGraph(Network& network, int channels, bool bfloat16) : bfloat16_(bfloat16) {
  // The plain executor: the profiling one specialises on the shapes that it sees first, and a batch
  // of another size then fails.
  jit::getProfilingMode() = false;
  jit::getExecutorMode() = false;
  network.eval();
  // Tensors that need no gradient enter a traced graph as constants.
  for (torch::Tensor& parameter : network.parameters()) parameter.set_requires_grad(false);
  const torch::NoGradGuard no_gradients;
  const auto forward = [&](jit::Stack inputs) {
    return jit::Stack{network.forward(inputs.front().toTensor())};
  };
  const auto unnamed = [](const torch::Tensor&) { return std::string(); };
  const auto type = bfloat16 ? torch::kBFloat16 : torch::kFloat32;
  if (bfloat16) network.to(type);  // integers, too, which a network to be saved needs as they are
  const auto traced = jit::tracer::trace({torch::zeros({1, channels}, type)}, forward, unnamed,
                                         /*strict=*/true, /*force_outplace=*/true);
  std::shared_ptr<jit::Graph> graph = traced.first->graph;
  jit::graph_rewrite_helper::replaceConvolutionWithAtenConv(graph);
  jit::ConstantPropagation(graph);
  fold_normalisation_into_dense_layers(*graph);
  std::shared_ptr<jit::Graph> one = graph->copy();
  make_dense_layers_matrix_vector(*one);
  many_frames_ = executor_of(std::move(graph));
  one_frame_ = executor_of(std::move(one));
}

FrozenGraph::~FrozenGraph() = default;
FrozenGraph::FrozenGraph(FrozenGraph&&) noexcept = default;
FrozenGraph& FrozenGraph::operator=(FrozenGraph&&) noexcept = default;

torch::Tensor FrozenGraph::run(const torch::Tensor& frames) const {
  const torch::NoGradGuard no_gradients;
  jit::Stack stack{bfloat16_ ? frames.to(torch::kBFloat16) : frames};
  (frames.size(0) == 1 ? one_frame_ : many_frames_)->run(stack);
  return stack.front().toTensor().to(torch::kFloat32);
}

}  // namespace ertbench
