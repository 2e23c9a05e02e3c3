#include "bench/limit/scene_voltages.h"

#include <algorithm>
#include <cmath>

#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

constexpr double resolution_of_one = 3;
constexpr double resolution_step = 1.6;
constexpr int most_border_points = 500;

class BorderVoltages : public SceneVoltages {
 public:
  explicit BorderVoltages(const Sensor& sensor) : model_(sensor) {}

  std::string name() const override { return "border model"; }
  const Eigen::VectorXd& reference() const override { return model_.reference_voltages(); }
  bool is_smooth() const override { return true; }

  void solve(std::span<const Scene> scenes, const VoltageTarget* target,
             Eigen::Ref<Frames> voltages) const override {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      voltages.row(static_cast<Eigen::Index>(i)) = voltages_of(
          scenes[i], target, target && !target->farthest.empty() ? target->farthest[i] : INFINITY);
    }
  }

 private:
  Eigen::VectorXd voltages_of(const Scene& scene, const VoltageTarget* target,
                              double farthest) const {
    const Eigen::VectorXd& reference = model_.reference_voltages();
    const bool one = scene.contacts.size() == 1 && scene.contacts[0].half_size.x() > 0 &&
                     scene.contacts[0].shape != Shape::rectangle;
    if (one) return reference + model_.solve_at(scene, resolution_of_one).change;
    double resolution = 1;
    for (;;) {
      const BorderModel::Solution solution = model_.solve_at(scene, resolution);
      Eigen::VectorXd voltages = reference + solution.change;
      if (!target || solution.points * resolution_step > most_border_points) return voltages;
      const double apart = (target->frame - voltages).norm();
      if (solution.error <= border_tolerance * std::max(target->noise, apart)) return voltages;
      if (apart - 2 * solution.error > farthest) return voltages;
      resolution *= resolution_step;
    }
  }

  BorderModel model_;
};

class GridVoltages : public SceneVoltages {
 public:
  GridVoltages(const Sensor& sensor, int side, Rasterisation rule)
      : model_(sensor, side), pixels_(sensor.sheet->pixels(side)), rule_(rule) {}

  std::string name() const override {
    return "grid of " + std::to_string(model_.grid()) + ", rasterised by " + name_of(rule_);
  }
  const Eigen::VectorXd& reference() const override { return model_.reference_voltages(); }
  bool is_smooth() const override { return rule_ == Rasterisation::area; }

  void solve(std::span<const Scene> scenes, const VoltageTarget*,
             Eigen::Ref<Frames> voltages) const override {
    Images sheets(static_cast<Eigen::Index>(scenes.size()), pixels_.count());
    Eigen::VectorXd ratio(pixels_.count());
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      rasterise(scenes[i], pixels_, rule_, ratio);
      sheets.row(static_cast<Eigen::Index>(i)) = model_.sensor().background * ratio;
    }
    voltages = model_.solve(sheets);
  }

 private:
  ForwardModel model_;
  PixelGrid pixels_;
  Rasterisation rule_;
};

}  // namespace

std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor) {
  return std::make_unique<BorderVoltages>(sensor);
}

std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule) {
  return std::make_unique<GridVoltages>(sensor, side, rule);
}

namespace {

/// The grid that a set's own voltages are computed on, where it is coarse enough to be solved
/// thousands of times; null for others.
const GridSheet* own_grid(const DatasetSpec& spec) {
  const auto* grid = std::get_if<GridSheet>(&spec.model);
  return grid && grid->side <= largest_own_grid ? grid : nullptr;
}

}  // namespace

bool has_other_model(const DatasetSpec& spec) {
  return std::holds_alternative<GridSheet>(spec.model) && !own_grid(spec);
}

std::string model_name(const DatasetSpec& spec, const SceneVoltages& voltages) {
  if (!has_other_model(spec)) return voltages.name();
  return voltages.name() + ", corrected by its difference to the grid of " + text_of(spec.model) +
         " at the posterior";
}

std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec) {
  const GridSheet* grid = own_grid(spec);
  if (!grid) return border_voltages(spec.sensor);
  return grid_voltages(spec.sensor, grid->side, spec.rasterisation);
}

}  // namespace ertbench
