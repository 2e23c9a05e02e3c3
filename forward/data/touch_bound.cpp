#include "forward/data/touch_bound.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <vector>

#include "forward/data/scene_model.h"
#include "forward/touch/skin_touch.h"

namespace ertbench {

double channel_noise(const DatasetSpec& spec, const SceneModel& model,
                     const Eigen::Ref<const Eigen::VectorXd>& frame) {
  return noise_norm(spec.noise, model.reference_voltages(), frame) /
         std::sqrt(static_cast<double>(frame.size()));
}

Eigen::Matrix3d touch_bound(const DatasetSpec& spec, const SceneModel& model, const Touch& touch) {
  DatasetSpec faultless = spec;
  faultless.faults = {};
  const std::array<double, 3> steps = {0.1, 0.1, 0.01 * touch.force_N};
  std::vector<Scene> scenes = {still_scene(spec.sensor, {&touch, 1})};
  for (int parameter = 0; parameter < 3; ++parameter) {
    for (const double sign : {1.0, -1.0}) {
      Touch moved = touch;
      const double step = sign * steps[static_cast<std::size_t>(parameter)];
      if (parameter < 2) moved.place_mm[parameter] += step;
      if (parameter == 2) moved.force_N += step;
      scenes.push_back(still_scene(spec.sensor, {&moved, 1}));
    }
  }
  const std::vector<std::uint64_t> numbers(scenes.size(), 0);
  Frames voltages(static_cast<Eigen::Index>(scenes.size()), spec.sensor.channels());
  RowMajorMatrix effort(voltages.rows(), 0);
  model.solve(faultless, scenes, numbers, voltages, effort);
  Eigen::MatrixX3d jacobian(spec.sensor.channels(), 3);
  for (int parameter = 0; parameter < 3; ++parameter) {
    jacobian.col(parameter) =
        (voltages.row(1 + 2 * parameter) - voltages.row(2 + 2 * parameter)).transpose() /
        (2 * steps[static_cast<std::size_t>(parameter)]);
  }
  const double noise = channel_noise(spec, model, voltages.row(0).transpose());
  return (jacobian.transpose() * jacobian).inverse() * noise * noise;
}

}  // namespace ertbench
