#pragma once

#include <Eigen/Core>

#include "forward/sheet/pixel_grid.h"

namespace ertbench {

/// The conductivity ratios of the patches of a skin: squares at equal distances, the ratio 1
/// between them.
struct PatchField {
  int patches = 0;        ///< along one side
  double width = 1;       ///< of a patch, as a fraction of the distance between their centres
  Eigen::VectorXd ratio;  ///< [patches^2] sigma / background, column + patches * row, as an image's
};

/// Conductivity ratios [pixels] of a skin's patches over the bounds of `pixels`, by the fraction of
/// each pixel's area that each patch covers.
void rasterise(const PatchField& field, const PixelGrid& pixels, Eigen::Ref<Eigen::VectorXd> ratio);

}  // namespace ertbench
