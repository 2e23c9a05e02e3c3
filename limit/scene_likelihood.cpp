#include "limit/scene_likelihood.h"

#include <algorithm>

#include "core/process.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {

double log_sum(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> logs(values.data(),
                                              static_cast<Eigen::Index>(values.size()));
  const double largest = logs.maxCoeff();
  return std::isfinite(largest) ? largest + std::log(exp_of(logs - largest).sum()) : largest;
}

namespace {

constexpr double resolution_of_one = 3;
constexpr double resolution_step = 1.6;
constexpr int most_border_points = 500;
/// Relative difference allowed between the frame's noise and that of a scene that explains it.
constexpr double noise_slack = 0.02;

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

/// The grid of the set's own voltages if it is coarse enough to be solved thousands of times.
const GridSheet* own_grid(const DatasetSpec& spec) {
  const auto* grid = std::get_if<GridSheet>(&spec.model);
  return grid && grid->side <= largest_own_grid ? grid : nullptr;
}

}  // namespace

Frames SceneVoltages::solve_all(std::span<const Scene> scenes, int threads) const {
  Frames out(static_cast<Eigen::Index>(scenes.size()), reference().size());
  parallel_for(scenes.size(), threads, [&](std::size_t begin, std::size_t end) {
    solve(scenes.subspan(begin, end - begin), nullptr,
          out.middleRows(static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin)));
  });
  return out;
}

std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor) {
  return std::make_unique<BorderVoltages>(sensor);
}

std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule) {
  return std::make_unique<GridVoltages>(sensor, side, rule);
}

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

FrameLikelihood::FrameLikelihood(const SceneVoltages& voltages, const Noise& noise,
                                 Eigen::VectorXd frame)
    : voltages_(voltages), noise_(noise), frame_(std::move(frame)) {}

double FrameLikelihood::channel_noise(const Eigen::Ref<const Eigen::VectorXd>& clean) const {
  // With the difference basis a sheet without contact has no noise beyond rounding.
  const double least = 1e-9 * voltages_.reference().norm();
  const double norm = std::max(least, noise_norm(noise_, voltages_.reference(), clean));
  return norm / std::sqrt(static_cast<double>(frame_.size()));
}

std::vector<SceneFit> FrameLikelihood::of_voltages(const Eigen::Ref<const Frames>& voltages) const {
  std::vector<SceneFit> fits(static_cast<std::size_t>(voltages.rows()));
  for (Eigen::Index i = 0; i < voltages.rows(); ++i) {
    const Eigen::VectorXd clean = voltages.row(i);
    const double noise = channel_noise(clean);
    SceneFit& fit = fits[static_cast<std::size_t>(i)];
    fit.noise = noise;
    fit.chi_square = (frame_ - clean).squaredNorm() / (noise * noise);
    fit.log_likelihood = -static_cast<double>(frame_.size()) * std::log(noise) - fit.chi_square / 2;
    // A scene that the model cannot solve explains nothing.
    if (!std::isfinite(fit.log_likelihood)) fit = {-1e300, 1e300, noise, {}};
  }
  return fits;
}

Frames FrameLikelihood::voltages_of(std::span<const Scene> scenes,
                                    std::span<const double> thresholds) const {
  Frames voltages(static_cast<Eigen::Index>(scenes.size()), frame_.size());
  const double channels = static_cast<double>(frame_.size());
  const double noise = channel_noise(frame_);
  VoltageTarget target{frame_, noise * std::sqrt(channels), {}};
  // With the difference basis the noise varies between scenes, so no distance can be ruled out.
  if (noise_.basis == SnrBasis::difference) thresholds = {};
  for (const double threshold : thresholds) {
    const double chi_square = -2 * (threshold + channels * std::log((1 - noise_slack) * noise));
    target.farthest.push_back((1 + noise_slack) * noise * std::sqrt(std::max(0.0, chi_square)));
  }
  voltages_.solve(scenes, &target, voltages);
  return voltages;
}

double FrameLikelihood::largest() const {
  return -static_cast<double>(frame_.size()) * std::log((1 - noise_slack) * channel_noise(frame_));
}

std::vector<SceneFit> FrameLikelihood::of(std::span<const Scene> scenes,
                                          std::span<const double> thresholds) const {
  const Frames voltages = voltages_of(scenes, thresholds);
  std::vector<SceneFit> fits = of_voltages(voltages);
  for (std::size_t i = 0; i < fits.size(); ++i) {
    if (fits[i].chi_square >= 1e300) continue;
    fits[i].rest =
        (frame_ - voltages.row(static_cast<Eigen::Index>(i)).transpose()) / fits[i].noise;
  }
  return fits;
}

Eigen::VectorXd sphere_weights(std::span<const double> chi_squares, int channels, double width) {
  Eigen::VectorXd logs(static_cast<Eigen::Index>(chi_squares.size()));
  for (Eigen::Index i = 0; i < logs.size(); ++i) {
    const double beyond = chi_squares[static_cast<std::size_t>(i)] - channels;
    logs[i] = beyond / 2 - beyond * beyond / (2 * width * width);
  }
  return exp_of(logs.array() - logs.maxCoeff());
}

}  // namespace ertbench
