#pragma once

#include <torch/types.h>

#include "core/arrays.h"

namespace ertbench {

class DatasetFile;

/// What networks are fed: the drop of each channel, v0 - v, less its mean over the training set and
/// divided by its standard deviation there.
struct Standardisation {
  Eigen::RowVectorXf mean;   ///< [channels] V
  Eigen::RowVectorXf scale;  ///< [channels] 1/V, one over the standard deviation
  /// What the images of a network are in: y = (1 - sigma / background) / image. 1 where contacts
  /// lower the conductivity; where they raise it, the largest rise of the training set is at y =
  /// .9, as the paper's networks know falls alone.
  double image = 1;

  static Standardisation of(const DatasetFile& training);

  /// `changes` [frames, channels] V, v - v0 -> [frames, channels].
  torch::Tensor apply(const FramesView& changes) const;
  /// The same for one frame, into contiguous memory [channels].
  template <typename Change>
  void apply(const Eigen::MatrixBase<Change>& change, float* out) const {
    Eigen::Map<Eigen::RowVectorXf>(out, mean.size()) =
        (-change.template cast<float>() - mean).cwiseProduct(scale);
  }
};

}  // namespace ertbench
