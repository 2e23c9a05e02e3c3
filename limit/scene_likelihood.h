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

// One value after the other: of Eigen's own vectorised functions GCC 12 says that they read what
// was never written.

template <typename Values>
Eigen::ArrayXd exp_of(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::exp(x); });
}

template <typename Values>
double sum_of_logs(const Eigen::ArrayBase<Values>& values) {
  return values.unaryExpr([](double x) { return std::log(x); }).sum();
}

/// A frame that voltages are computed for.
struct VoltageTarget {
  const Eigen::VectorXd& frame;
  double noise;  ///< 2-norm, V
  std::vector<double>
      farthest;  ///< [scenes] V from the frame: beyond, any accuracy will do; or none
};

/// What computes the clean voltages of the many scenes that a posterior is sampled with: a forward
/// model as it is, or a faster one for the scenes that it knows.
///
/// All functions are const and thread-safe.
class SceneVoltages {
 public:
  virtual ~SceneVoltages() = default;

  virtual std::string name() const = 0;  ///< as results have it: "border, resolution 1"
  /// Voltages of the uniform sheet, [channels] V.
  virtual const Eigen::VectorXd& reference() const = 0;
  /// `voltages` [scenes, channels] V. `target`: what they are to be held against, and need be no
  /// more accurate than; null where the first glance is enough.
  virtual void solve(std::span<const Scene> scenes, const VoltageTarget* target,
                     Eigen::Ref<Frames> voltages) const = 0;
  /// Whether the voltages are smooth in a contact's place and size, as those of pixels that a
  /// contact has or has not are not.
  virtual bool is_smooth() const = 0;
};

/// BorderModel. One disc or ellipse is solved at a resolution whose error is under .02 of the noise
/// of 50 dB everywhere. Other scenes, first at resolution 1, are refined until the error that
/// reciprocity shows is at most `border_tolerance` of the noise, or of the distance to the frame
/// where that is larger: a scene that is far off need not be known well to be refused.
std::unique_ptr<SceneVoltages> border_voltages(const Sensor& sensor);
inline constexpr double border_tolerance = 0.25;
/// ForwardModel on a grid of `side` pixels that are filled by `rule`.
std::unique_ptr<SceneVoltages> grid_voltages(const Sensor& sensor, int side, Rasterisation rule);

/// The largest grid that is solved as it is; of finer ones the border model is the limit.
inline constexpr int largest_own_grid = 48;

/// Whether voltages_for() is another model than the set's own by more than both are accurate to.
bool has_other_model(const DatasetSpec& spec);
/// As results have it: with what is done about the difference, where there is one.
std::string model_name(const DatasetSpec& spec, const SceneVoltages& voltages);

/// The model that made the set's own voltages where it is a grid coarse enough to be solved
/// thousands of times; for finer grids and "auto" the border model, to which they converge.
std::unique_ptr<SceneVoltages> voltages_for(const DatasetSpec& spec);

/// How well a scene explains a frame.
struct SceneFit {
  /// Up to a constant of the frame.
  double log_likelihood = 0;
  /// |frame - voltages|^2 over the variance of the noise of one channel: about as many as there are
  /// channels for a scene that explains the frame.
  double chi_square = 0;
  double noise = 0;      ///< of a channel, V
  Eigen::VectorXd rest;  ///< [channels] frame - voltages, in units of the noise, or empty: not kept
};

/// The density of one frame, given a scene: what samplers are asked to explain. Tests put known
/// ones in the place of a frame's.
class SceneLikelihood {
 public:
  virtual ~SceneLikelihood() = default;
  /// Of each scene; const and thread-safe. `thresholds` [scenes] or none: log likelihoods under
  /// which a value need not be accurate.
  virtual std::vector<SceneFit> of(std::span<const Scene> scenes,
                                   std::span<const double> thresholds = {}) const = 0;
  /// Above which no scene's log likelihood is.
  virtual double largest() const { return std::numeric_limits<double>::infinity(); }
};

/// That of a measured frame. The noise of a set has a direction like white noise and a norm r that
/// the scene's own voltages v set exactly (add_noise): the frame y lies on a sphere around v. White
/// Gaussian noise of variance r^2 / channels in every channel stands in for it,
///
///     log L = -channels log r - |y - v|^2 channels / (2 r^2),
///
/// whose posterior has the same mean to first order: in the linear regime the sphere cuts from the
/// Gaussian posterior the shell of one distance around the same centre. What is lost is the
/// knowledge of that distance; sphere_weights() puts it back.
class FrameLikelihood : public SceneLikelihood {
 public:
  /// `frame` [channels] V. `voltages` must outlive this. `noise` has a strength.
  FrameLikelihood(const SceneVoltages& voltages, const Noise& noise, Eigen::VectorXd frame);

  std::vector<SceneFit> of(std::span<const Scene> scenes,
                           std::span<const double> thresholds = {}) const override;
  double largest() const override;
  /// The same without their rests, of voltages [scenes, channels] V that are known already.
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

/// Factors that take samples under the Gaussian likelihood to samples on the sphere, thickened to
/// a Gaussian of standard deviation `width` in the chi square, whose value on the sphere is
/// `channels`: exp((chi^2 - channels) / 2) exp(-(chi^2 - channels)^2 / (2 width^2)), the largest
/// of them 1.
Eigen::VectorXd sphere_weights(std::span<const double> chi_squares, int channels, double width);

}  // namespace ertbench
