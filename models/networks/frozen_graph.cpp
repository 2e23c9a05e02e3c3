#include "models/networks/frozen_graph.h"

#include <torch/csrc/jit/frontend/tracer.h>
#include <torch/csrc/jit/passes/constant_propagation.h>
#include <torch/csrc/jit/passes/dead_code_elimination.h>
#include <torch/csrc/jit/passes/frozen_graph_optimizations.h>
#include <torch/csrc/jit/passes/frozen_ops_to_mkldnn.h>
#include <torch/csrc/jit/passes/graph_rewrite_helper.h>
#include <torch/csrc/jit/runtime/graph_executor.h>

#include "models/networks/dense_layers.h"

namespace ertbench {

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
