#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/faults.h"

namespace ertbench {

// Evaluated value by value: GCC 12 warns of uninitialised reads in Eigen's vectorised functions.

template <typename Values>
Eigen::ArrayXd exp_of(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::exp(x); });
}

template <typename Values>
double sum_of_logs(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::log(x); }).sum();
}

/// Logarithm of the sum of exp(values); minus infinity if all are.
double log_sum(const std::vector<double>& values);

/// The frame that voltages are compared with, which sets their accuracy.
struct VoltageTarget {
  const Eigen::VectorXd& frame;
  double noise;  ///< 2-norm, V
  /// [scenes] distance from the frame in V beyond which any accuracy is enough; or empty.
  std::vector<double> farthest;
};

/// Computes clean voltages of the many scenes that a posterior is sampled with: a forward model, or
/// a faster approximation of it.
///
/// All functions are const and thread-safe.
class SceneVoltages {
 public:
  virtual ~SceneVoltages() = default;

  virtual std::string name() const = 0;  ///< its name in results
  /// Voltages of the uniform sheet, [channels] V.
  virtual const Eigen::VectorXd& reference() const = 0;
  /// Fills in `voltages` [scenes, channels] V, only as accurately as `target` demands; null: at the
  /// lowest accuracy.
  virtual void solve(std::span<const Scene> scenes, const VoltageTarget* target,
                     Eigen::Ref<Frames> voltages) const = 0;
  /// Voltages [scenes, channels] V at the lowest accuracy, in several threads.
  Frames solve_all(std::span<const Scene> scenes, int threads) const;
  /// True if the voltages are smooth in a contact's position and size; they are not where a pixel
  /// either belongs to a contact or does not.
  virtual bool is_smooth() const = 0;
};

/// Uses BorderModel. A single disc or ellipse is solved at a resolution whose error is below .02 of
/// the noise of 50 dB everywhere. Other scenes start at resolution 1 and are refined until the
/// error, as estimated from reciprocity, is at most `border_tolerance` of the noise or of the
/// distance to the frame, whichever is larger.
std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor);
inline constexpr double border_tolerance = 0.25;
/// Uses ForwardModel on a grid of `side` pixels that are filled by `rule`.
std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule);

/// The finest grid that is solved itself; finer ones are replaced by the border model.
inline constexpr int largest_own_grid = 48;

/// True if voltages_for() differs from the set's own model by more than their accuracy.
bool has_other_model(const DatasetSpec& spec);
/// The model's name in results; it mentions the correction if has_other_model().
std::string model_name(const DatasetSpec& spec, const SceneVoltages& voltages);

/// The model that made the set's own voltages if that is a grid coarse enough to be solved
/// thousands of times; for finer grids and "auto" the border model, to which they converge.
std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec);

/// How well a scene explains a frame.
struct SceneFit {
  double log_likelihood = 0;  ///< up to a constant of the frame
  /// |frame - voltages|^2 over the noise variance of one channel: near the number of channels for a
  /// scene that explains the frame.
  double chi_square = 0;
  double noise = 0;      ///< standard deviation in one channel, V
  Eigen::VectorXd rest;  ///< [channels] frame - voltages in units of the noise; or empty: not kept
};

/// The likelihood of scenes given one frame, which samplers ask for. Tests substitute known ones.
class SceneLikelihood {
 public:
  virtual ~SceneLikelihood() = default;
  /// Returns the fit of each scene; thread-safe. `thresholds` [scenes] or empty: log likelihoods
  /// below which a value need not be accurate.
  virtual std::vector<SceneFit> of(std::span<const Scene> scenes,
                                   std::span<const double> thresholds = {}) const = 0;
  /// An upper bound of the log likelihood of any scene.
  virtual double largest() const { return std::numeric_limits<double>::infinity(); }
};

/// The likelihood of a measured frame. A set's noise has the direction of white noise and a norm r
/// that the scene's voltages v determine exactly (add_noise), so the frame y lies on a sphere
/// around v. The likelihood replaces it by white Gaussian noise of variance r^2 / channels,
///
///     log L = -channels log r - |y - v|^2 channels / (2 r^2),
///
/// whose posterior has the same mean to first order: in the linear regime the sphere cuts a shell
/// around the same centre from the Gaussian posterior. sphere_weights() restores the knowledge of
/// the distance, which the Gaussian ignores.
class FrameLikelihood : public SceneLikelihood {
 public:
  /// `frame` [channels] V. `voltages` must outlive this. `noise` has a strength.
  FrameLikelihood(const SceneVoltages& voltages, const Noise& noise, Eigen::VectorXd frame);

  std::vector<SceneFit> of(std::span<const Scene> scenes,
                           std::span<const double> thresholds = {}) const override;
  double largest() const override;
  /// Fits without their rests, for known voltages [scenes, channels] V.
  std::vector<SceneFit> of_voltages(const Eigen::Ref<const Frames>& voltages) const;

  /// Clean voltages [scenes, channels] V, as accurate as the frame demands.
  Frames voltages_of(std::span<const Scene> scenes, std::span<const double> thresholds = {}) const;
  const Eigen::VectorXd& frame() const { return frame_; }
  /// Noise of one channel on a frame of these clean voltages, V.
  double channel_noise(const Eigen::Ref<const Eigen::VectorXd>& clean) const;

 private:
  const SceneVoltages& voltages_;
  Noise noise_;
  Eigen::VectorXd frame_;
};

/// Weights that turn samples under the Gaussian likelihood into samples near the sphere, where
/// chi^2 equals `channels`: exp((chi^2 - channels) / 2) exp(-(chi^2 - channels)^2 / (2 width^2)),
/// scaled to a maximum of 1.
Eigen::VectorXd sphere_weights(std::span<const double> chi_squares, int channels, double width);

}  // namespace ertbench
