#pragma once

#include <memory>

namespace torch::jit {
struct Graph;
}

namespace ertbench {

/// Puts each batch normalisation that follows a dense layer into the layer's weights, all of them
/// constants of a traced graph. libtorch does so for convolutions only.
void fold_normalisation_into_dense_layers(torch::jit::Graph& graph);

/// Makes matrix-vector products of the dense layers of a graph that takes one frame. OpenBLAS's
/// matrix-matrix product would copy all the weights into another order, frame after frame.
void make_dense_layers_matrix_vector(torch::jit::Graph& graph);

}  // namespace ertbench
