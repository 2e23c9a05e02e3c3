#include "models/training/sheet_mask.h"

namespace ertbench {

torch::Tensor sheet_mask(const Sensor& sensor) {
  const PixelGrid pixels = sensor.image();
  if (pixels.all_on_sheet()) return {};
  torch::Tensor mask = torch::zeros({1, 1, pixels.rows(), pixels.columns()});
  for (int p = 0; p < pixels.count(); ++p) mask.data_ptr<float>()[p] = pixels.on_sheet(p) ? 1 : 0;
  return mask;
}

}  // namespace ertbench
