#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/json.h"
#include "forward/border/border_model.h"
#include "forward/data/scene_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"
#include "python/module/arrays.h"

namespace ertbench {
namespace {

/// The models of one sensor: the continuous sheet's and those on grids, each made when first asked
/// for.
class Models {
 public:
  /// `grid`: pixels along the longer side; 0 for the continuous sheet.
  Models(const Sensor& sensor, int grid) : sensor_(sensor), grid_(grid) {
    if (grid_ == 0) {
      border_.emplace(sensor);
    } else {
      on_grid(grid_);
    }
  }

  Array reference() const {
    const Eigen::VectorXd& voltages =
        border_ ? border_->reference_voltages() : on_grid(grid_).reference_voltages();
    return array_of(voltages.transpose(), {voltages.size()});
  }

  Array voltages_of_images(const py::handle& images, int threads) const {
    const Array numbers = numbers_of(images, "images");
    const int grid = grid_of(numbers);
    const Sheet& sheet = *sensor_.sheet;
    const Rows rows = rows_of(numbers, "images",
                              {sheet.image_rows(grid), sheet.image_columns(grid)}, "S/m", false);
    if (rows.view().size() > 0 && !(rows.view().minCoeff() > 0)) {
      throw InputError("images: must be conductivities > 0 S/m, not their changes; the least is " +
                       std::to_string(rows.view().minCoeff()));
    }
    const ForwardModel& model = on_grid(grid);
    Array out = rows.make({sensor_.channels()});
    Eigen::Map<Frames> frames(out.mutable_data(), rows.count, sensor_.channels());
    for_blocks(rows.count, grid <= 48 ? 64 : 16, threads, [&](auto begin, auto end) {
      frames.middleRows(begin, end - begin) =
          model.solve(rows.view().middleRows(begin, end - begin));
    });
    return out;
  }

  /// Voltages [N, channels] of a JSON list of scenes, and the estimated errors [N] V, relative to
  /// the norm of the change.
  py::tuple voltages_of_scenes(const std::string& text, double accuracy, int threads) const {
    const nlohmann::json list = parse_json(text, "scenes");
    std::vector<Scene> scenes;
    for (std::size_t i = 0; i < list.size(); ++i) {
      scenes.push_back(
          scene_from_json(JsonObject(list[i], "", "/" + std::to_string(i)), *sensor_.sheet));
    }
    const auto count = static_cast<Eigen::Index>(scenes.size());
    Frames frames(count, sensor_.channels());
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(count);
    for_blocks(count, border_ ? 1 : 64, threads, [&](auto begin, auto end) {
      if (!border_) {
        solve_on_grid({scenes.data() + begin, scenes.data() + end},
                      frames.middleRows(begin, end - begin));
        return;
      }
      for (Eigen::Index i = begin; i < end; ++i) {
        const auto tolerance = [&](const Eigen::VectorXd& change) {
          return accuracy * change.norm();
        };
        const auto solution = border_->solve(scenes[static_cast<std::size_t>(i)], tolerance);
        frames.row(i) = border_->reference_voltages() + solution.change;
        const double norm = solution.change.norm();
        errors[i] = norm > 0 ? solution.error / norm : 0;
      }
    });
    return py::make_tuple(array_of(frames, {count, frames.cols()}),
                          array_of(errors.transpose(), {count}));
  }

  /// [channels, rows, columns] V per S/m, of the uniform sheet or, on a grid, at an image.
  Array jacobian(const py::object& at) const {
    const int grid = grid_ == 0 ? sensor_.image_grid : grid_;
    const py::ssize_t rows = sensor_.sheet->image_rows(grid);
    const py::ssize_t columns = sensor_.sheet->image_columns(grid);
    RowMajorMatrix derivatives;
    if (at.is_none()) {
      const py::gil_scoped_release unlocked;
      derivatives = border_ ? border_jacobian(sensor_) : on_grid(grid).jacobian();
    } else {
      const Rows image = rows_of(at, "at", {rows, columns}, "S/m");
      if (!image.single) throw InputError("at: must be one image, got " + shape_text(image.array));
      if (!(image.view().row(0).array() > 0).all()) throw InputError("at: must be > 0, S/m");
      const ForwardModel& model = on_grid(grid);
      const py::gil_scoped_release unlocked;
      derivatives = model.jacobian(image.view().row(0).transpose());
    }
    return array_of(derivatives, {sensor_.channels(), rows, columns});
  }

 private:
  /// The grid of images [..., rows, columns]: the model's or, of the continuous sheet's model,
  /// theirs.
  int grid_of(const Array& images) const {
    if (grid_ != 0 || images.ndim() < 2) return grid_ != 0 ? grid_ : sensor_.image_grid;
    const py::ssize_t longer =
        std::max(images.shape(images.ndim() - 1), images.shape(images.ndim() - 2));
    int grid = sensor_.image_grid;
    while (grid < longer && grid < 1536) grid *= 2;
    return grid == longer ? grid : sensor_.image_grid;
  }

  const ForwardModel& on_grid(int grid) const {
    const std::lock_guard lock(mutex_);
    auto& model = grids_[grid];
    if (!model) {
      if (!fits_grid(sensor_, grid)) {
        throw InputError("grid: " + std::to_string(grid) + " does not serve this " +
                         sensor_.sheet->name() +
                         ": finite elements are for squares and rectangles in square pixels with "
                         "point electrodes on their nodes; give contacts, with grid=\"auto\"");
      }
      model = std::make_unique<ForwardModel>(sensor_, grid);
    }
    return *model;
  }

  void solve_on_grid(std::span<const Scene> scenes, Eigen::Ref<Frames> frames) const {
    const PixelGrid pixels = sensor_.sheet->pixels(grid_);
    Images sheets(frames.rows(), pixels.count());
    Eigen::VectorXd ratio(pixels.count());
    for (Eigen::Index i = 0; i < sheets.rows(); ++i) {
      rasterise(scenes[static_cast<std::size_t>(i)], pixels, Rasterisation::area, ratio);
      sheets.row(i) = sensor_.background * ratio;
    }
    frames = on_grid(grid_).solve(sheets);
  }

  Sensor sensor_;
  int grid_;
  std::optional<BorderModel> border_;
  mutable std::mutex mutex_;
  mutable std::map<int, std::unique_ptr<ForwardModel>> grids_;
};

}  // namespace

void bind_forward(py::module_& module) {
  py::class_<Models>(module, "ForwardModel")
      .def(py::init<const Sensor&, int>(), py::arg("sensor"), py::arg("grid"))
      .def("reference", &Models::reference)
      .def("_of_images", &Models::voltages_of_images)
      .def("_of_scenes", &Models::voltages_of_scenes)
      .def("jacobian", &Models::jacobian, py::arg("at") = py::none(),
           "Derivatives of the voltages with respect to the pixels' conductivities, [channels, "
           "rows,\n"
           "columns] V per S/m.\n\n"
           "Of the uniform sheet or, on a grid, at the image `at` [rows, columns] S/m.");
}

}  // namespace ertbench
