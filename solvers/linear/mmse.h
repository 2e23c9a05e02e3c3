#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "solvers/channel_mask.h"
#include "solvers/linear/linear_solver.h"
#include "solvers/linear/mixture.h"
#include "solvers/nuisances.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"

namespace ertbench {

/// Matrix [pixels, pairs] of the linear estimate of least mean squared error,
///
///     x = cross (changes + added 1)^-1 d'
///
/// from second moments `changes` [pairs, pairs] and `cross` [pixels, pairs]; `added` >= 0, V^2.
Eigen::MatrixXd mmse_matrix(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross,
                            double added);

/// Parameters of both kinds of "lmmse".
struct MmseParameters {
  bool symmetries = true;
  Tunable ridge;
  Nuisances nuisances;

  /// `{"ridge": > 0 | "auto", "symmetries": bool}` and what Nuisances read.
  void read(JsonObject& parameters);
  void add_to(nlohmann::json& parameters) const;
  /// Chooses the ridge if it is "auto".
  void settle(const Solver& solver, const FitInput& input, const std::function<void(double)>& set);
};

/// Linear minimum-mean-square-error reconstruction, type "lmmse" with one component: the matrix
/// with the least mean squared error of images over the training scenes,
///
///     image = E[x d^T] (E[d d^T] + ridge)^-1 changes.
///
/// It is the posterior mean if changes and images are jointly Gaussian with mean zero, and maps a
/// frame without a change to an empty image. The moments are those of the training set, whose
/// voltages include noise and follow no linear model. (From C_xx by the Jacobian,
/// C_xx J^T (J C_xx J^T + noise)^-1, the mean relative error is .77 instead of .62 on one to three
/// contacts.) `ridge` is additional noise, relative to the mean square of the changes of all pairs;
/// it trades errors of strong contacts for errors of weak ones. Nuisances add N N^T to E[d d^T].
///
/// With `"inference_noise": "frame"` noise and ridge are weighted by the noise of each frame, as
/// its reciprocal pairs show it, in place of that of the training set (SpectralInverse).
class LinearMmse final : public LinearSolver {
 public:
  static constexpr const char* type = "lmmse";

  /// `{"components": 1, "inference_noise": "fit" | "frame"}` and what MmseParameters,
  /// LinearInference and ChannelMask read.
  explicit LinearMmse(JsonObject parameters);

  nlohmann::json parameters() const override;
  bool needs_training() const override { return true; }
  void fit(const FitInput& input) override;

 private:
  void read(JsonObject parameters) override;
  nlohmann::json fit_parameters() const override;
  void save_fit(Hdf5File& file) const override;
  void load_fit(const Hdf5File& file, const Sensor& sensor) override;
  std::unique_ptr<const FrameInverse> frame_inverse() const override;
  bool follows_noise() const override { return follows_noise_; }
  /// V^2, for a ridge.
  double added(double ridge) const { return ridge * changes_.diagonal().mean(); }

  bool follows_noise_ = false;  ///< "inference_noise"
  MmseParameters settings_;
  // Second moments of all pairs, for frames with dead electrodes.
  Eigen::MatrixXd changes_;  ///< [pairs, pairs]
  Eigen::MatrixXd cross_;    ///< [pixels, pairs]
};

/// Minimum-mean-square-error image under a mixture of Gaussians fitted to the training scenes, type
/// "lmmse" with several components. Each component covers contacts of similar position and strength
/// and has its own linear estimate; the image is the mean of these, weighted by the posterior
/// probabilities. A frame costs the probabilities of all components (24 x 24 numbers each) and the
/// matrices of the two or three likely ones. In single precision.
///
/// Dead electrodes are marginalised out of the Gaussians, which is exact except for the choice of
/// the directions; the result is cached for the sets of electrodes met last.
class MixtureMmse final : public Solver, public LayeredSolver {
 public:
  static constexpr const char* type = "lmmse";

  /// `{"components": 2 ... 1024}` and what MmseParameters and ChannelMask read.
  explicit MixtureMmse(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override { mask_.check(sensor); }
  bool needs_training() const override { return true; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  std::optional<LayerList> layers() const override;
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  void read(JsonObject parameters);
  void set_sensor(const Sensor& sensor);
  void set_mean();
  /// The estimator without the channels of these electrodes and of those masked in every frame;
  /// null if no channel is left.
  std::shared_ptr<const MixtureMean> mean_without(ElectrodeSet dead) const;

  int components_ = 2;
  MmseParameters settings_;
  ChannelMask mask_;
  Sensor sensor_;
  Reciprocity reciprocity_;
  GaussianMixture mixture_;
  std::shared_ptr<const MixtureMean> mean_;
  mutable std::mutex masked_mutex_;
  mutable std::map<ElectrodeSet, std::shared_ptr<const MixtureMean>> masked_;
};

}  // namespace ertbench
