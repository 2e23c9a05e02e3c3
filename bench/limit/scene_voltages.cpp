#include "bench/limit/scene_voltages.h"

#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

class BorderVoltages : public SceneVoltages {
 public:
  BorderVoltages(const Sensor& sensor, double resolution)
      : model_(sensor), resolution_(resolution) {}

  std::string name() const override { return "border, resolution " + number_text(resolution_); }
  const Eigen::VectorXd& reference() const override { return model_.reference_voltages(); }
  bool is_smooth() const override { return true; }

  void solve(std::span<const Scene> scenes, Eigen::Ref<Frames> voltages) const override {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      voltages.row(static_cast<Eigen::Index>(i)) =
          model_.reference_voltages() + model_.solve_at(scenes[i], resolution_).change;
    }
  }

 private:
  BorderModel model_;
  double resolution_;
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

  void solve(std::span<const Scene> scenes, Eigen::Ref<Frames> voltages) const override {
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

std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor, double resolution) {
  return std::make_unique<BorderVoltages>(sensor, resolution);
}

std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule) {
  return std::make_unique<GridVoltages>(sensor, side, rule);
}

std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec) {
  const auto* grid = std::get_if<GridSheet>(&spec.model);
  if (grid && grid->side <= largest_own_grid) {
    return grid_voltages(spec.sensor, grid->side, spec.rasterisation);
  }
  return border_voltages(spec.sensor);
}

}  // namespace ertbench
