#pragma once

#include <vector>

namespace ertbench {

/// Components of a mixture with less than this share of the largest probability are left out.
inline constexpr float least_mixture_share = 1e-3F;

/// One layer of a network, as data. A value is a vector, or a stack of maps
/// [channels][row][column].
struct Layer {
  enum class Kind {
    input,
    dense,                   ///< weights [outputs][inputs]
    gather,                  ///< output i is number indices[i] of the input, 0 where that is -1
    means_of_pairs,          ///< output i is the mean of numbers indices[2 i] and indices[2 i + 1]
    maps,                    ///< a vector as maps
    convolution,             ///< weights [outputs][inputs][kernel][kernel], inputs concatenated
    transposed_convolution,  ///< the same, of a transposed convolution
    pool,                    ///< the maximum over each 2 x 2 pixels
    attention,               ///< weights [2][kernel][kernel] of the maps of means and of maxima
    shuffle,  ///< 4 maps as one of twice the side, map 2 (row % 2) + column % 2 at row, column
    sigmoid,  ///< in place: `value` is its input
    /// Estimates weights [component][outputs][inputs] x + constant, weighted by the components'
    /// probabilities. The first input, which it may overwrite, is [component][coordinate], of which
    /// half the squares' sum is taken from the logarithm of the component's weight; the second is
    /// x. `bias` [component][1 + outputs]: that logarithm, then the constant.
    mixture,
  };

  Kind kind = Kind::input;
  std::vector<int> inputs = {};  ///< values
  int value = 0;                 ///< that it makes
  int channels = 1;              ///< of its value
  int height = 1;
  int width = 1;
  int added = -1;  ///< value that is added before the activation; of a shuffle, 4 maps or more
  int kernel = 1;
  int stride = 1;
  int padding = 0;
  bool relu = false;
  std::vector<float> weights = {};
  std::vector<float> bias = {};    ///< [outputs]
  std::vector<float> slopes = {};  ///< of a PReLU [outputs]
  std::vector<int> indices = {};
};

/// A reconstruction as data: the layers in order, between the change of the voltages and that of
/// the conductivity.
struct LayerList {
  std::vector<Layer> layers;
  /// Per channel: the input of the first layer is (change of the voltage - shift) scale. Empty: the
  /// change itself, V.
  std::vector<float> shift;
  std::vector<float> scale;
  double unit = 1;  ///< S/m: the image is unit times the last value
};

}  // namespace ertbench
