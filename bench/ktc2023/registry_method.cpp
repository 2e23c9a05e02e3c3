#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "bench/experiment/experiment_solvers.h"
#include "bench/ktc2023/ktc_methods.h"
#include "bench/ktc2023/simulated_tanks.h"
#include "bench/run/datasets.h"
#include "bench/run/timing_stage.h"
#include "forward/data/sheet_model.h"
#include "solvers/registry/named_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

/// Drive pairs that are present and independent of those before, with all measuring pairs present.
std::vector<ChannelElectrodes> independent_channels(const KtcPatterns& patterns,
                                                    const Eigen::VectorXd& present) {
  const Eigen::Index count = patterns.measurements.cols();
  const auto pair_of = [](const Eigen::VectorXd& from) {
    ElectrodePair pair{};
    from.minCoeff(&pair.first);
    from.maxCoeff(&pair.second);
    return pair;
  };
  std::vector<ChannelElectrodes> out;
  Eigen::MatrixXd basis(TankModel::electrodes, 0);
  for (Eigen::Index d = 0; d < patterns.currents.cols(); ++d) {
    const auto measured = present.segment(d * count, count);
    if (measured.isZero(0)) continue;
    Eigen::VectorXd current = patterns.currents.col(d).normalized();
    current -= basis * (basis.transpose() * current);
    constexpr double independent = 1e-6;
    if (current.norm() < independent) continue;
    basis.conservativeResize(Eigen::NoChange, basis.cols() + 1);
    basis.rightCols(1) = current.normalized();
    for (Eigen::Index m = 0; m < count; ++m) {
      if (measured[m] == 0) continue;
      out.push_back({pair_of(patterns.currents.col(d)), pair_of(-patterns.measurements.col(m))});
    }
  }
  return out;
}

/// A tank of unit currents. By default it is driven as KTC2023's drives are independent, from each
/// odd electrode to the next, and measured between neighbours that are not driven.
Sensor tank_sensor(double conductivity, double contact_impedance, int image_grid,
                   bool measures_driven = false) {
  constexpr double radius_mm = 1000 * TankModel::radius;
  constexpr double width = std::numbers::pi / TankModel::electrodes;
  nlohmann::json json = {{"shape", "disc"},
                         {"measurement", "adjacent"},
                         {"diameter_mm", 2 * radius_mm},
                         {"electrode_model", "complete"},
                         {"contact_impedance", contact_impedance},
                         {"electrode_width_mm", radius_mm * width},
                         {"drive_current", 1},
                         {"background", conductivity},
                         {"image_grid", image_grid},
                         {"measures_driven", measures_driven}};
  for (int e = 0; e < TankModel::electrodes; ++e) {
    const double angle = std::numbers::pi / 2 + 2 * width * e;
    json["electrode_points_mm"].push_back(
        {radius_mm * std::cos(angle), radius_mm * std::sin(angle)});
    if (e % 2 == 0) json["drive"].push_back({e, (e + 2) % TankModel::electrodes});
  }
  return sensor_from_json(JsonObject(json, "the tank of KTC2023", ""));
}

/// Changes of the resistances between electrodes, [32, 32] ohm, that explain all channels best; NaN
/// where no channel depends on them.
Eigen::MatrixXd resistances_of(const KtcSetting& setting, const KtcFrame& frame,
                               const RegistryOptions& options) {
  KtcMisfit misfit(setting, frame, options.noise, options.model_error);
  misfit.normal.diagonal().array() += 1e-3;  // holds what no channel sees
  const Eigen::VectorXd packed = misfit.normal.llt().solve(misfit.side);
  Eigen::VectorXd all = Eigen::VectorXd::Constant(TankModel::pairs, NAN);
  all(misfit.pairs) = packed;
  Eigen::MatrixXd out(TankModel::electrodes, TankModel::electrodes);
  Eigen::Index at = 0;
  for (int a = 0; a < TankModel::electrodes; ++a) {
    for (int b = a; b < TankModel::electrodes; ++b) out(a, b) = out(b, a) = all[at++];
  }
  return out;
}

/// The image of a frame, S/m, [grid, grid]; zero where there is none.
Eigen::MatrixXd image_of(const Solver& solver, const Frames& changes, int grid) {
  Images image = Images::Zero(1, Eigen::Index{grid} * grid);
  FrameReport report;
  solver.reconstruct(changes, image, {&report, 1});
  if (report.status == FrameStatus::undefined) image.setZero();
  // Rows of the image one behind the other are the columns of this map.
  return Eigen::Map<const Eigen::MatrixXd>(image.data(), grid, grid).transpose();
}

/// A square image on 256 x 256 pixels, bilinear, row 0 on top.
Eigen::MatrixXd resampled(const Eigen::MatrixXd& image) {
  constexpr int size = 256;
  const Eigen::Index grid = image.rows();
  const auto weights = [&](bool turned) {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size, grid);
    for (Eigen::Index i = 0; i < size; ++i) {
      const double at =
          std::clamp((static_cast<double>(i) + 0.5) * static_cast<double>(grid) / size - 0.5, 0.0,
                     static_cast<double>(grid - 1));
      const auto low = std::min(static_cast<Eigen::Index>(at), grid - 2);
      const Eigen::Index row = turned ? size - 1 - i : i;
      out(row, low + 1) = at - static_cast<double>(low);
      out(row, low) = 1 - out(row, low + 1);
    }
    return out;
  };
  return weights(true) * image * weights(false).transpose();
}

class RegistryMethod final : public KtcMethod {
 public:
  explicit RegistryMethod(RegistryOptions options) : options_(std::move(options)) {
    registry_.allow_plugins();
  }

  void prepare(const KtcSetting& setting, const KtcFrame& frame) override {
    Fitted& fitted = fitted_[key_of(setting, frame)];
    if (fitted.solver) return;
    fitted.channels = independent_channels(*setting.patterns, frame.present);
    if (fitted.channels.empty()) throw InputError("a target of KTC2023 has no channel");
    FitInput input;
    // The electrodes' admittances are replaced by their mean.
    input.sensor =
        with_channels(tank_sensor(setting.calibration.conductivity,
                                  1 / setting.calibration.contact_impedance.cwiseInverse().mean(),
                                  options_.image_grid, true),
                      fitted.channels);
    fitted.solver = fitted_solver(
        {JsonValue(options_.solver), options_.source + ": " + options_.path}, input, registry_);
  }

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    const Fitted& fitted = fitted_.at(key_of(setting, frame));
    const Frames changes =
        ideal_voltages(fitted.channels, resistances_of(setting, frame, options_));
    KtcImage out{resampled(image_of(*fitted.solver, changes, options_.image_grid)), std::nullopt};
    out.change /= setting.calibration.conductivity;
    if (!fitted.solver->contact_finder()) return out;
    // Contacts have conductivities of their own: those of at least twice the water's or at most
    // half of it are the classes.
    out.classes = out.change.unaryExpr([](double x) { return x > 1 ? 2 : x < -0.5 ? 1 : 0; });
    out.change = out.change.unaryExpr([](double x) { return std::log(std::max(1 + x, 0.05)); });
    return out;
  }

 private:
  struct Fitted {
    std::vector<ChannelElectrodes> channels;
    std::unique_ptr<Solver> solver;
  };
  using Key = std::pair<const KtcSetting*, std::vector<double>>;
  static Key key_of(const KtcSetting& setting, const KtcFrame& frame) {
    return {&setting, {frame.present.begin(), frame.present.end()}};
  }

  RegistryOptions options_;
  SolverRegistry registry_;
  std::map<Key, Fitted> fitted_;
};

/// A solver that was trained on simulated tanks of unit conductivity, one for all levels: the
/// channels of electrodes that a level lacks read zero.
class TrainedMethod final : public KtcMethod {
 public:
  explicit TrainedMethod(RegistryOptions options)
      : options_(std::move(options)),
        sensor_(tank_sensor(1, usual_impedance, options_.image_grid)),
        channels_(electrodes_of_channels(sensor_)),
        reference_(uniform_reference(sensor_).transpose()) {
    registry_.allow_plugins();
  }

  void prepare(const KtcSetting&, const KtcFrame&) override {
    if (solver_) return;
    FitRecipe recipe;
    recipe.entry.label = recipe.entry.type = options_.solver.at("type");
    recipe.entry.spec = JsonValue(options_.solver);
    recipe.entry.path = options_.path;
    recipe.source = options_.source;
    recipe.sensor = sensor_;
    describe(recipe.entry, registry_.load(recipe.entry.type));
    const Cache cache = Cache::standard();
    const CacheShare share(cache, CacheShare::Of::run);
    if (!options_.solver.contains("checkpoint")) {
      const int held_out = options_.scenes / 16;
      recipe.training = tanks(held_out, options_.scenes, "train", cache);
      recipe.validation = tanks(0, held_out, "validation", cache);
    }
    solver_ = fitted_solver(recipe, cache, registry_, usable_cores(), {}).solver;
  }

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    Frames changes = setting.calibration.conductivity *
                     ideal_voltages(channels_, resistances_of(setting, frame, options_));
    changes = changes.array().isNaN().select(-reference_, changes);
    // Classes are 0, 1/2 and 1, of which the background stands for 1; off the tank is water.
    Eigen::MatrixXd image = 2 * image_of(*solver_, changes, options_.image_grid).array() + 1;
    const PixelGrid pixels = sensor_.image();
    for (int p = 0; p < pixels.count(); ++p) {
      if (!pixels.on_sheet(p)) image(p / pixels.columns(), p % pixels.columns()) = 0;
    }
    KtcImage out{resampled(image), std::nullopt};
    out.classes = out.change.unaryExpr([](double x) { return x > 0.5 ? 2 : x < -0.5 ? 1 : 0; });
    return out;
  }

 private:
  /// Tanks [from, to) of the simulated ones, as a set in the cache.
  DatasetSpec tanks(int from, int to, const char* name, const Cache& cache) const {
    const TrainingTanks all{sensor_, options_.scenes, 1};
    const nlohmann::json json = {
        {"file", all.file_in(cache.folder() / "ktc2023", usable_cores()).string()},
        {"rows", {from, to}},
        {"snr_db", 60},
        {"snr_basis", "absolute"}};
    DatasetSpec out = dataset_spec_from_json(JsonObject(json, options_.source, ""), sensor_, name,
                                             cache.folder());
    std::filesystem::create_directories(cache.folder() / "datasets");
    ensure_dataset(out, cache, usable_cores());
    return out;
  }

  static constexpr double usual_impedance = 1e-6;  ///< ohm m, at 1 S

  RegistryOptions options_;
  Sensor sensor_;
  std::vector<ChannelElectrodes> channels_;
  Frames reference_;  ///< [1, channels] V
  SolverRegistry registry_;
  std::unique_ptr<Solver> solver_;
};

}  // namespace

std::unique_ptr<KtcMethod> registry_method(RegistryOptions options) {
  SolverRegistry registry;
  registry.allow_plugins();
  // Making it also refuses what is wrong.
  const bool trained =
      registry.make(JsonObject(options.solver, options.source, options.path))->needs_training();
  if (trained || options.solver.contains("checkpoint")) {
    return std::make_unique<TrainedMethod>(std::move(options));
  }
  return std::make_unique<RegistryMethod>(std::move(options));
}

}  // namespace ertbench
