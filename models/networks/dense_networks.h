#pragma once

#include <torch/nn/modules/container/sequential.h>

#include <array>
#include <memory>
#include <vector>

#include "forward/sheet/sensor.h"
#include "models/networks/network.h"

namespace torch::jit {
struct Graph;
}

namespace ertbench {

/// Folds batch normalisations after dense layers into their weights in a traced graph with constant
/// weights. libtorch does this for convolutions only.
void fold_normalisation_into_dense_layers(torch::jit::Graph& graph);

/// Replaces the dense layers of a graph for single frames by matrix-vector products. OpenBLAS's
/// matrix-matrix product would reorder all weights for every frame.
void make_dense_layers_matrix_vector(torch::jit::Graph& graph);

/// FCNN: dense layers, each but the last with batch normalisation and ReLU,
///
///     208 -> 2304 -> 576 -> 576 -> 576 (linear).
///
/// EIT-NN without its convolutions; comparing the two shows the benefit of convolutions.
class Fcnn final : public Network {
 public:
  /// `widths`: of the hidden layers. `told`: further inputs behind the channels.
  Fcnn(const Sensor& sensor, const std::vector<int>& widths, int told = 0);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(PlanBuilder plan) const override;

 private:
  torch::nn::Sequential layers_;
  int inputs_;
  int rows_;
  int columns_;
};

/// Appends dense layers with batch normalisation and ReLU; returns the width of the last.
int append_dense_layers(torch::nn::Sequential& layers, int inputs, const std::vector<int>& widths);

/// DCNN: the frame as a map [drive, measurement], zero for skipped measurements, through a
/// convolutional encoder and decoder:
///
///     1 x 16 x 16 -> 3x3 convolution w0 -> pool -> 3x3 w1 -> pool -> 3x3 w2 (4 x 4)
///     -> transposed convolution 3x3, stride 3, w1 -> transposed 2x2, stride 2, w0
///     -> 3x3 convolution -> 1 x 24 x 24 (linear)
///
/// with batch normalisation and PReLU after each but the last; the usual convolutional baseline of
/// electrical impedance tomography.
class Dcnn final : public Network {
 public:
  /// `widths`: w0, w1, w2.
  Dcnn(const Sensor& sensor, const std::array<int, 3>& widths);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(PlanBuilder plan) const override;

  /// Throws InputError unless the number of electrodes is a multiple of four and the image's grid
  /// 3/2 of it, so that the map can be scaled to the image.
  static void check(const Sensor& sensor);

 private:
  torch::nn::Sequential layers_;
  torch::Tensor source_;  ///< [map] channel of each element; one past the last channel: none; on
                          ///< the device of the last frames
  int channels_;
  int drives_;
  int measurements_;
};

/// EIT-NN (Park, Park, Jang, Kim: "Deep neural network based electrical impedance tomographic
/// sensing methodology for large-area robotic tactile sensing", T-RO 2021):
///
///     dense 208 -> 2304 -> 576 -> 576 (batch normalisation, ReLU) -> 1 x 24 x 24
///     -> 3x3 convolution 32 -> 3x3 convolution 64 (batch normalisation, ReLU, no bias)
///     -> 3x3 transposed convolution 1 (linear)
class EitNn final : public Network {
 public:
  /// `dense_widths`: the last must be the number of pixels. `channels`: of the two convolutions.
  EitNn(const Sensor& sensor, const std::vector<int>& dense_widths,
        const std::array<int, 2>& channels);
  torch::Tensor forward(const torch::Tensor& frames) override;
  std::unique_ptr<InferencePlan> plan(PlanBuilder plan) const override;

 private:
  torch::nn::Sequential dense_, convolutions_;
  int inputs_;
  int rows_;
  int columns_;
};

}  // namespace ertbench
