include "forward/border/border_model.h" #include "limit/scene_likelihood.h" include
        "forward/border/border_model.h" include "forward/border/border_model.h" #include<algorithm>
            include "forward/border/border_model.h" #include<cmath> include
    "forward/border/border_model.h" include "forward/border/border_model.h" include
    "forward/border/border_model.h" #include "core/process.h"
#include "forward/border/border_model.h"
    include "forward/border/border_model.h" #include "forward/fem/forward_model.h" include
    "forward/border/border_model.h" include "forward/border/border_model.h" namespace ertbench {
  include "forward/border/border_model.h" namespace {
    include "forward/border/border_model.h" include
            "forward/border/border_model.h" constexpr double resolution_of_one = 3;
    include "forward/border/border_model.h" constexpr double resolution_step = 1.6;
    include "forward/border/border_model.h" constexpr int most_border_points = 500;
    include "forward/border/border_model.h"  /// Relative difference allowed between the frame's
                                             /// noise and that of a scene that explains it.
        include "forward/border/border_model.h" constexpr double noise_slack = 0.02;
    include "forward/border/border_model.h" include
            "forward/border/border_model.h" class BorderVoltages : public SceneVoltages {
      include "forward/border/border_model.h" public
          : include "forward/border/border_model.h" explicit BorderVoltages(const Sensor& sensor)
          : model_(sensor) {}
      include "forward/border/border_model.h" include "forward/border/border_model.h" std::string
      name() const override {
        return "border model";
      }
      include "forward/border/border_model.h" const Eigen::VectorXd& reference() const override {
        return model_.reference_voltages();
      }
      include "forward/border/border_model.h" bool is_smooth() const override { return true; }
      include "forward/border/border_model.h" include "forward/border/border_model.h" void solve(
          std::span<const Scene> scenes, const VoltageTarget* target,
          include "forward/border/border_model.h" Eigen::Ref<Frames> voltages) const override {
        include "forward/border/border_model.h" for (std::size_t i = 0; i < scenes.size(); ++i) {
          include "forward/border/border_model.h" voltages.row(static_cast<Eigen::Index>(i)) =
              voltages_of(include "forward/border/border_model.h" scenes[i], target,
                          target && !target->farthest.empty() ? target->farthest[i] : INFINITY);
          include "forward/border/border_model.h"
        }
        include "forward/border/border_model.h"
      }
      include "forward/border/border_model.h" include "forward/border/border_model.h" private
          : include "forward/border/border_model.h" Eigen::VectorXd
            voltages_of(const Scene& scene, const VoltageTarget* target,
                        include "forward/border/border_model.h" double farthest) const {
        include "forward/border/border_model.h" const Eigen::VectorXd& reference =
            model_.reference_voltages();
        include "forward/border/border_model.h" const bool one =
            scene.contacts.size() == 1 && scene.contacts[0].half_size.x() > 0 &&
            include "forward/border/border_model.h" scene.contacts[0].shape != Shape::rectangle;
        include "forward/border/border_model.h" if (one) return reference +
            model_.solve_at(scene, resolution_of_one).change;
        include "forward/border/border_model.h" double resolution = 1;
        include "forward/border/border_model.h" for (;;) {
          include "forward/border/border_model.h" const BorderModel::Solution solution =
              model_.solve_at(scene, resolution);
          include "forward/border/border_model.h" Eigen::VectorXd voltages =
              reference + solution.change;
          include "forward/border/border_model.h" if (!target ||
                                                      solution.points * resolution_step >
                                                          most_border_points) return voltages;
          include "forward/border/border_model.h" const double apart =
              (target->frame - voltages).norm();
          include "forward/border/border_model.h" if (solution.error <=
                                                      border_tolerance *
                                                          std::max(target->noise,
                                                                   apart)) return voltages;
          include "forward/border/border_model.h" if (apart - 2 * solution.error >
                                                      farthest) return voltages;
          include "forward/border/border_model.h" resolution *= resolution_step;
          include "forward/border/border_model.h"
        }
        include "forward/border/border_model.h"
      }
      include "forward/border/border_model.h" include
              "forward/border/border_model.h" BorderModel model_;
      include "forward/border/border_model.h"
    };
    include "forward/border/border_model.h" include
            "forward/border/border_model.h" class GridVoltages : public SceneVoltages {
      include "forward/border/border_model.h" public
          : include "forward/border/border_model.h" GridVoltages(const Sensor& sensor, int side,
                                                                 Rasterisation rule) include
            "forward/border/border_model.h" : model_(sensor, side),
                                              pixels_(sensor.sheet->pixels(side)),
                                              rule_(rule) {}
      include "forward/border/border_model.h" include "forward/border/border_model.h" std::string
      name() const override {
        include "forward/border/border_model.h" return "grid of " + std::to_string(model_.grid()) +
            ", rasterised by " + name_of(rule_);
        include "forward/border/border_model.h"
      }
      include "forward/border/border_model.h" const Eigen::VectorXd& reference() const override {
        return model_.reference_voltages();
      }
      include "forward/border/border_model.h" bool is_smooth() const override {
        return rule_ == Rasterisation::area;
      }
      include "forward/border/border_model.h" include "forward/border/border_model.h" void solve(
          std::span<const Scene> scenes, const VoltageTarget*,
          include "forward/border/border_model.h" Eigen::Ref<Frames> voltages) const override {
        include "forward/border/border_model.h" Images sheets(
            static_cast<Eigen::Index>(scenes.size()), pixels_.count());
        include "forward/border/border_model.h" Eigen::VectorXd ratio(pixels_.count());
        include "forward/border/border_model.h" for (std::size_t i = 0; i < scenes.size(); ++i) {
          include "forward/border/border_model.h" rasterise(scenes[i], pixels_, rule_, ratio);
          include "forward/border/border_model.h" sheets.row(static_cast<Eigen::Index>(i)) =
              model_.sensor().background * ratio;
          include "forward/border/border_model.h"
        }
        include "forward/border/border_model.h" voltages = model_.solve(sheets);
        include "forward/border/border_model.h"
      }
      include "forward/border/border_model.h" include "forward/border/border_model.h" private
          : include "forward/border/border_model.h" ForwardModel model_;
      include "forward/border/border_model.h" PixelGrid pixels_;
      include "forward/border/border_model.h" Rasterisation rule_;
      include "forward/border/border_model.h"
    };
    include "forward/border/border_model.h" include "forward/border/border_model.h"
  }  // namespace
  include "forward/border/border_model.h" include "forward/border/border_model.h" Frames
  SceneVoltages::solve_all(std::span<const Scene> scenes, int threads) const {
    include "forward/border/border_model.h" Frames out(static_cast<Eigen::Index>(scenes.size()),
                                                       reference().size());
    include "forward/border/border_model.h" parallel_for(
        scenes.size(), threads, [&](std::size_t begin, std::size_t end) {
          include "forward/border/border_model.h" solve(
              scenes.subspan(begin, end - begin), nullptr,
              include "forward/border/border_model.h" out.middleRows(
                  static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end - begin)));
          include "forward/border/border_model.h"
        });
    include "forward/border/border_model.h" return out;
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" include
          "forward/border/border_model.h" std::unique_ptr<SceneVoltages>
          border_voltages(const Sensor& sensor) {
    include "forward/border/border_model.h" return std::make_unique<BorderVoltages>(sensor);
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" include
          "forward/border/border_model.h" std::unique_ptr<SceneVoltages>
          grid_voltages(const Sensor& sensor, int side, Rasterisation rule) {
    include
        "forward/border/border_model.h" return std::make_unique<GridVoltages>(sensor, side, rule);
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" include "forward/border/border_model.h" namespace {
      include "forward/border/border_model.h" include
              "forward/border/border_model.h"  /// The grid of the set's own voltages if it is
                                               /// coarse enough to be solved thousands of times.
      include "forward/border/border_model.h" const GridSheet *
      own_grid(const DatasetSpec& spec){include "forward/border/border_model.h" const auto* grid =
                                            std::get_if<GridSheet>(&spec.model);
  include "forward/border/border_model.h" return grid && grid->side <= largest_own_grid ? grid
                                                                                        : nullptr;
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h"
}  // namespace
include "forward/border/border_model.h" include "forward/border/border_model.h" bool
has_other_model(const DatasetSpec& spec) {
  include "forward/border/border_model.h" return std::holds_alternative<GridSheet>(spec.model) &&
      !own_grid(spec);
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h" std::string
model_name(const DatasetSpec& spec, const SceneVoltages& voltages) {
  include "forward/border/border_model.h" if (!has_other_model(spec)) return voltages.name();
  include "forward/border/border_model.h" return voltages.name() +
      ", corrected by its difference to the grid of " + text_of(spec.model) +
      include
      "forward/border/border_model.h"
      " at the posterior";
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include
        "forward/border/border_model.h" std::unique_ptr<SceneVoltages>
        voltages_for(const DatasetSpec& spec) {
  include "forward/border/border_model.h" const GridSheet* grid = own_grid(spec);
  include "forward/border/border_model.h" if (!grid) return border_voltages(spec.sensor);
  include "forward/border/border_model.h" return grid_voltages(spec.sensor, grid->side,
                                                               spec.rasterisation);
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include
        "forward/border/border_model.h" FrameLikelihood::FrameLikelihood(
            const SceneVoltages& voltages, const Noise& noise,
            include "forward/border/border_model.h" Eigen::VectorXd frame) include
    "forward/border/border_model.h" : voltages_(voltages),
                                      noise_(noise),
                                      frame_(std::move(frame)) {}
include "forward/border/border_model.h" include "forward/border/border_model.h" double
FrameLikelihood::channel_noise(const Eigen::Ref<const Eigen::VectorXd>& clean) const {
  include "forward/border/border_model.h"  // With the difference basis a sheet without contact has
                                           // no noise beyond rounding.
      include "forward/border/border_model.h" const double least =
          1e-9 * voltages_.reference().norm();
  include "forward/border/border_model.h" const double norm =
      std::max(least, noise_norm(noise_, voltages_.reference(), clean));
  include "forward/border/border_model.h" return norm /
      std::sqrt(static_cast<double>(frame_.size()));
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include
        "forward/border/border_model.h" std::vector<SceneFit>
        FrameLikelihood::of_voltages(const Eigen::Ref<const Frames>& voltages) const {
  include "forward/border/border_model.h" std::vector<SceneFit> fits(
      static_cast<std::size_t>(voltages.rows()));
  include "forward/border/border_model.h" for (Eigen::Index i = 0; i < voltages.rows(); ++i) {
    include "forward/border/border_model.h" const Eigen::VectorXd clean = voltages.row(i);
    include "forward/border/border_model.h" const double noise = channel_noise(clean);
    include "forward/border/border_model.h" SceneFit& fit = fits[static_cast<std::size_t>(i)];
    include "forward/border/border_model.h" fit.noise = noise;
    include "forward/border/border_model.h" fit.chi_square =
        (frame_ - clean).squaredNorm() / (noise * noise);
    include "forward/border/border_model.h" fit.log_likelihood =
        -static_cast<double>(frame_.size()) * std::log(noise) - fit.chi_square / 2;
    include
        "forward/border/border_model.h"  // A scene that the model cannot solve explains nothing.
        include "forward/border/border_model.h" if (!std::isfinite(fit.log_likelihood))
            fit = {-1e300, 1e300, noise, {}};
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" return fits;
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h" Frames
FrameLikelihood::voltages_of(
    std::span<const Scene> scenes,
    include "forward/border/border_model.h" std::span<const double> thresholds) const {
  include "forward/border/border_model.h" Frames voltages(static_cast<Eigen::Index>(scenes.size()),
                                                          frame_.size());
  include "forward/border/border_model.h" const double channels =
      static_cast<double>(frame_.size());
  include "forward/border/border_model.h" const double noise = channel_noise(frame_);
  include
      "forward/border/border_model.h" VoltageTarget target{frame_, noise * std::sqrt(channels), {}};
  include "forward/border/border_model.h"  // With the difference basis the noise varies between
                                           // scenes, so no distance can be ruled out.
      include "forward/border/border_model.h" if (noise_.basis == SnrBasis::difference)
          thresholds = {};
  include "forward/border/border_model.h" for (const double threshold : thresholds) {
    include "forward/border/border_model.h" const double chi_square =
        -2 * (threshold + channels * std::log((1 - noise_slack) * noise));
    include "forward/border/border_model.h" target.farthest.push_back(
        (1 + noise_slack) * noise * std::sqrt(std::max(0.0, chi_square)));
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" voltages_.solve(scenes, &target, voltages);
  include "forward/border/border_model.h" return voltages;
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h" double
FrameLikelihood::largest() const {
  include "forward/border/border_model.h" return -static_cast<double>(frame_.size()) *
      std::log((1 - noise_slack) * channel_noise(frame_));
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include
        "forward/border/border_model.h" std::vector<SceneFit>
        FrameLikelihood::of(
            std::span<const Scene> scenes,
            include "forward/border/border_model.h" std::span<const double> thresholds) const {
  include "forward/border/border_model.h" const Frames voltages = voltages_of(scenes, thresholds);
  include "forward/border/border_model.h" std::vector<SceneFit> fits = of_voltages(voltages);
  include "forward/border/border_model.h" for (std::size_t i = 0; i < fits.size(); ++i) {
    include "forward/border/border_model.h" if (fits[i].chi_square >= 1e300) continue;
    include "forward/border/border_model.h" fits[i].rest =
        include "forward/border/border_model.h"(
            frame_ - voltages.row(static_cast<Eigen::Index>(i)).transpose()) /
        fits[i].noise;
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" return fits;
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h" Eigen::VectorXd
sphere_weights(std::span<const double> chi_squares, int channels, double width) {
  include "forward/border/border_model.h" Eigen::VectorXd logs(
      static_cast<Eigen::Index>(chi_squares.size()));
  include "forward/border/border_model.h" for (Eigen::Index i = 0; i < logs.size(); ++i) {
    include "forward/border/border_model.h" const double beyond =
        chi_squares[static_cast<std::size_t>(i)] - channels;
    include "forward/border/border_model.h" logs[i] =
        beyond / 2 - beyond * beyond / (2 * width * width);
    include "forward/border/border_model.h"
  }
  include "forward/border/border_model.h" return exp_of(logs.array() - logs.maxCoeff());
  include "forward/border/border_model.h"
}
include "forward/border/border_model.h" include "forward/border/border_model.h"
}  // namespace ertbench
