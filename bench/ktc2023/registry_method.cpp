#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "bench/ktc2023/ktc_methods.h"
#include "core/errors.h"
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

/// The calibrated tank of unit currents; the electrodes' admittances are replaced by their mean.
Sensor tank_sensor(const KtcCalibration& calibration, int image_grid) {
  constexpr double radius_mm = 1000 * TankModel::radius;
  constexpr double width = std::numbers::pi / TankModel::electrodes;
  nlohmann::json json = {
      {"shape", "disc"},
      {"diameter_mm", 2 * radius_mm},
      {"electrode_model", "complete"},
      {"contact_impedance", 1 / calibration.contact_impedance.cwiseInverse().mean()},
      {"electrode_width_mm", radius_mm * width},
      {"drive_current", 1},
      {"background", calibration.conductivity},
      {"image_grid", image_grid},
      {"measures_driven", true}};
  for (int e = 0; e < TankModel::electrodes; ++e) {
    const double angle = 84.375 / 180 * std::numbers::pi + 2 * width * e;
    json["electrode_points_mm"].push_back(
        {radius_mm * std::cos(angle), radius_mm * std::sin(angle)});
  }
  return sensor_from_json(JsonObject(json, "the tank of KTC2023", ""));
}

class RegistryMethod final : public KtcMethod {
 public:
  explicit RegistryMethod(RegistryOptions options) : options_(std::move(options)) {
    registry_.allow_plugins();
    const JsonObject solver(options_.solver, options_.source, "");
    if (registry_.make(solver)->needs_training()) {  // which also refuses what is wrong
      throw InputError(options_.source + ": " + options_.solver.value("type", "the solver") +
                       " is trained, and this experiment has no training set; name a solver that "
                       "is not, or a fitted file in \"checkpoint\"");
    }
  }

  void prepare(const KtcSetting& setting, const KtcFrame& frame) override {
    Fitted& fitted = fitted_[key_of(setting, frame)];
    if (fitted.solver) return;
    fitted.channels = independent_channels(*setting.patterns, frame.present);
    if (fitted.channels.empty()) throw InputError("a target of KTC2023 has no channel");
    FitInput input;
    input.sensor =
        with_channels(tank_sensor(setting.calibration, options_.image_grid), fitted.channels);
    fitted.solver = fitted_solver({JsonValue(options_.solver), options_.source}, input, registry_);
  }

  KtcImage reconstruct(const KtcSetting& setting, const KtcFrame& frame) const override {
    const Fitted& fitted = fitted_.at(key_of(setting, frame));
    const Frames changes = frame_of(fitted.channels, resistances_of(setting, frame));
    Images image = Images::Zero(1, Eigen::Index{options_.image_grid} * options_.image_grid);
    FrameReport report;
    fitted.solver->reconstruct(changes, image, {&report, 1});
    if (report.status == FrameStatus::undefined) image.setZero();
    KtcImage out{resampled(image / setting.calibration.conductivity), std::nullopt};
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

  /// Changes of the resistances between electrodes, [32, 32] ohm, that explain all channels best.
  Eigen::MatrixXd resistances_of(const KtcSetting& setting, const KtcFrame& frame) const {
    KtcMisfit misfit(setting, frame, options_.noise, options_.model_error);
    misfit.normal.diagonal().array() += 1e-3;  // holds what no channel sees
    const Eigen::VectorXd packed = misfit.normal.llt().solve(misfit.side);
    Eigen::VectorXd all = Eigen::VectorXd::Zero(TankModel::pairs);
    all(misfit.pairs) = packed;
    Eigen::MatrixXd out(TankModel::electrodes, TankModel::electrodes);
    Eigen::Index at = 0;
    for (int a = 0; a < TankModel::electrodes; ++a) {
      for (int b = a; b < TankModel::electrodes; ++b) out(a, b) = out(b, a) = all[at++];
    }
    return out;
  }

  static Frames frame_of(const std::vector<ChannelElectrodes>& channels,
                         const Eigen::MatrixXd& resistance) {
    Frames out(1, std::ssize(channels));
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto [drive, measured] = channels[c];
      const auto potential = [&](int electrode) {
        return resistance(electrode, drive.second) - resistance(electrode, drive.first);
      };
      out(0, static_cast<Eigen::Index>(c)) = potential(measured.first) - potential(measured.second);
    }
    return out;
  }

  /// Bilinear, row 0 on top.
  Eigen::MatrixXd resampled(const Eigen::MatrixXd& image) const {
    constexpr int size = 256;
    const Eigen::Index grid = options_.image_grid;
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
    // Rows of the image one behind the other are the columns of this map.
    const Eigen::Map<const Eigen::MatrixXd> transposed(image.data(), grid, grid);
    return weights(true) * transposed.transpose() * weights(false).transpose();
  }

  RegistryOptions options_;
  SolverRegistry registry_;
  std::map<Key, Fitted> fitted_;
};

}  // namespace

std::unique_ptr<KtcMethod> registry_method(RegistryOptions options) {
  return std::make_unique<RegistryMethod>(std::move(options));
}

}  // namespace ertbench
