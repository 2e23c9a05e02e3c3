#include "models/networks/dense_layers.h"

#include <torch/csrc/jit/ir/ir.h>
#include <torch/csrc/jit/passes/dead_code_elimination.h>
#include <torch/types.h>

#include <optional>
#include <vector>

namespace ertbench {
namespace {

namespace jit = torch::jit;
namespace aten = c10::aten;

/// A tensor known when the graph is made; without a value for what is computed, or none at all.
std::optional<torch::Tensor> constant_tensor(jit::Value* value) {
  const auto constant = jit::toIValue(value);
  if (!constant || !constant->isTensor()) return std::nullopt;
  return constant->toTensor();
}

/// Scale and shift per channel of a normalisation with fixed statistics.
struct Affine {
  torch::Tensor scale;
  torch::Tensor shift;
};

/// aten::batch_norm(input, weight, bias, mean, variance, training, momentum, eps, ...).
std::optional<Affine> affine_of(jit::Node* normalisation) {
  std::vector<torch::Tensor> tensors;
  for (const std::size_t input : {1, 2, 3, 4}) {
    const auto tensor = constant_tensor(normalisation->input(input));
    if (!tensor) return std::nullopt;
    tensors.push_back(*tensor);
  }
  const auto training = jit::toIValue(normalisation->input(5));
  const auto eps = jit::toIValue(normalisation->input(7));
  if (!training || training->toBool() || !eps) return std::nullopt;
  const torch::Tensor scale = tensors[0] * torch::rsqrt(tensors[3] + eps->toDouble());
  return Affine{scale, tensors[1] - tensors[2] * scale};
}

/// A dense layer as it is traced, with constant weights: aten::matmul(input, weights) or
/// aten::addmm(bias, input, weights, 1, 1).
struct DenseLayer {
  jit::Node* node;
  jit::Value* input;
  torch::Tensor weights;  ///< [inputs, outputs]
  torch::Tensor bias;     ///< [outputs]
};

std::optional<DenseLayer> dense_layer(jit::Node* node) {
  const bool biased = node->kind() == aten::addmm;
  if (!biased && node->kind() != aten::matmul) return std::nullopt;
  const auto weights = constant_tensor(node->input(biased ? 2 : 1));
  if (!weights || weights->dim() != 2) return std::nullopt;
  if (!biased) {
    return DenseLayer{node, node->input(0), *weights,
                      torch::zeros({weights->size(1)}, weights->options())};
  }
  const auto bias = constant_tensor(node->input(0));
  if (!bias) return std::nullopt;
  return DenseLayer{node, node->input(1), *weights, *bias};
}

std::vector<DenseLayer> dense_layers(jit::Graph& graph) {
  std::vector<DenseLayer> out;
  for (jit::Node* node : graph.nodes()) {
    if (const auto layer = dense_layer(node)) out.push_back(*layer);
  }
  return out;
}

}  // namespace

void fold_normalisation_into_dense_layers(jit::Graph& graph) {
  const torch::NoGradGuard no_gradients;
  for (const DenseLayer& layer : dense_layers(graph)) {
    const auto& uses = layer.node->output()->uses();
    if (uses.size() != 1 || uses[0].user->kind() != aten::batch_norm) continue;
    jit::Node* normalisation = uses[0].user;
    const auto affine = affine_of(normalisation);
    if (!affine) continue;
    const jit::WithInsertPoint before(layer.node);
    jit::Value* weights = graph.insertConstant(layer.weights * affine->scale);
    jit::Value* bias = graph.insertConstant(layer.bias * affine->scale + affine->shift);
    normalisation->output()->replaceAllUsesWith(
        graph.insert(aten::addmm, {bias, layer.input, weights}));
    normalisation->destroy();
    layer.node->destroy();
  }
}

void make_dense_layers_matrix_vector(jit::Graph& graph) {
  for (const DenseLayer& layer : dense_layers(graph)) {
    if (layer.weights.scalar_type() != torch::kFloat32) continue;
    const jit::WithInsertPoint before(layer.node);
    jit::Value* bias = graph.insertConstant(layer.bias);
    jit::Value* matrix = graph.insertConstant(layer.weights.t().contiguous());
    jit::Value* vector = graph.insert(aten::squeeze, {layer.input, 0});
    jit::Value* product = graph.insert(aten::addmv, {bias, matrix, vector});
    layer.node->output()->replaceAllUsesWith(graph.insert(aten::unsqueeze, {product, 0}));
    layer.node->destroy();
  }
}

}  // namespace ertbench
