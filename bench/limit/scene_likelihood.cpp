#include "bench/limit/scene_likelihood.h"

#include <algorithm>
#include <cmath>

#include "bench/limit/elementwise.h"

namespace ertbench {
namespace {

/// The noise of a scene that explains the frame is that of the frame to a small part of itself.
constexpr double noise_slack = 0.02;

}  // namespace

FrameLikelihood::FrameLikelihood(const SceneVoltages& voltages, const Noise& noise,
                                 Eigen::VectorXd frame)
    : voltages_(voltages), noise_(noise), frame_(std::move(frame)) {}

double FrameLikelihood::channel_noise(const Eigen::Ref<const Eigen::VectorXd>& clean) const {
  // By the difference basis an untouched sheet has no noise at all; rounding is left of it.
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
  // By the difference basis a scene's own noise may be another, and any distance within its chi.
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
