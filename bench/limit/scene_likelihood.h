#pragma once

#include <limits>
#include <span>
#include <vector>

#include "bench/limit/scene_voltages.h"
#include "forward/data/noise.h"

namespace ertbench {

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
