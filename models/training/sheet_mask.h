#pragma once

#include <torch/types.h>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// 1 for pixels that are on the sheet and 0 for those that are not, [1, 1, rows, columns];
/// undefined where the sheet fills its image.
torch::Tensor sheet_mask(const Sensor& sensor);

/// Images as they count: without what lies off the sheet. As they are where `mask` is undefined.
inline torch::Tensor masked(const torch::Tensor& images, const torch::Tensor& mask) {
  return mask.defined() ? images * mask : images;
}

}  // namespace ertbench
