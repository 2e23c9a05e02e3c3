#include "forward/data/scene_model.h"

#include <optional>

#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

void solve_on_grid(const ForwardModel& model, const DatasetSpec& spec,
                   std::span<const Scene> scenes, std::span<const std::uint64_t> numbers,
                   Eigen::Ref<Frames> voltages) {
  // A few scenes at a time: their fine images are the largest arrays here.
  const PixelGrid pixels = spec.sensor.sheet->pixels(model.grid());
  const Eigen::Index batch = model.grid() <= 48 ? 64 : 16;
  const auto count = static_cast<Eigen::Index>(scenes.size());
  Images sheets(std::min(batch, count), pixels.count());
  Eigen::VectorXd ratio(pixels.count());
  for (Eigen::Index start = 0; start < count; start += batch) {
    const Eigen::Index rows = std::min(batch, count - start);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto index = static_cast<std::size_t>(start + i);
      rasterise(scenes[index], pixels, spec.rasterisation, ratio);
      if (spec.faults.background_gradient > 0) {
        RandomStream random = spec.stream(numbers[index], Purpose::gradient);
        ratio.array() *= gradient_factors(spec.faults, *spec.sensor.sheet, pixels, random).array();
      }
      sheets.row(i) = spec.sensor.background * ratio;
    }
    voltages.middleRows(start, rows) = model.solve(sheets.topRows(rows));
  }
}

void solve_on_borders(const BorderModel& nominal, const DatasetSpec& spec,
                      std::span<const Scene> scenes, std::span<const std::uint64_t> numbers,
                      Eigen::Ref<Frames> voltages, Eigen::Ref<RowMajorMatrix> effort) {
  const double model_error = std::get<ContinuousSheet>(spec.model).model_error;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    std::optional<BorderModel> displaced;
    if (spec.faults.electrode_displacement > 0) {
      RandomStream random = spec.stream(numbers[i], Purpose::displacement);
      displaced.emplace(spec.sensor, displacements(spec.faults, spec.sensor, random));
    }
    const BorderModel& model = displaced ? *displaced : nominal;
    const bool stale = spec.faults.displacement_reference == DisplacementReference::stale;
    const Eigen::VectorXd& reference =
        stale ? model.reference_voltages() : nominal.reference_voltages();
    // Of the frame as the set holds it; what divides its voltages divides their error.
    const double divisor = 1 + spec.faults.background_change;
    const auto tolerance = [&](const Eigen::VectorXd& change) {
      return model_error * divisor *
             noise_norm(spec.noise, nominal.reference_voltages(), (reference + change) / divisor);
    };
    const BorderModel::Solution solution = model.solve(scenes[i], tolerance);
    const auto row = static_cast<Eigen::Index>(i);
    voltages.row(row) = reference + solution.change;
    effort.row(row) << solution.points, solution.error / divisor;
  }
}

}  // namespace

struct SceneModel::Parts {
  std::optional<ForwardModel> grid;
  std::optional<BorderModel> borders;
};

SceneModel::SceneModel(const Sensor& sensor, const SheetModel& model)
    : parts_(std::make_unique<Parts>()) {
  if (const auto* grid = std::get_if<GridSheet>(&model)) {
    parts_->grid.emplace(sensor, grid->side);
  } else {
    parts_->borders.emplace(sensor);
  }
}
SceneModel::~SceneModel() = default;
SceneModel::SceneModel(SceneModel&&) noexcept = default;

const Eigen::VectorXd& SceneModel::reference_voltages() const {
  return parts_->borders ? parts_->borders->reference_voltages()
                         : parts_->grid->reference_voltages();
}

void SceneModel::solve(const DatasetSpec& spec, std::span<const Scene> scenes,
                       std::span<const std::uint64_t> numbers, Eigen::Ref<Frames> voltages,
                       Eigen::Ref<RowMajorMatrix> effort) const {
  if (parts_->borders) {
    solve_on_borders(*parts_->borders, spec, scenes, numbers, voltages, effort);
  } else {
    solve_on_grid(*parts_->grid, spec, scenes, numbers, voltages);
  }
  voltages /= 1 + spec.faults.background_change;
}

}  // namespace ertbench
