#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/iterated/gauss_newton_iteration.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/tunable.h"

namespace ertbench {

/// Iterated Gauss-Newton reconstruction: the image whose voltages, by the grid model and not by its
/// linearisation, fit the changes, with a penalty on it,
///
///     min over t of 1/2 |F(t) - changes|^2 + penalty(t),
///
/// t the variable of BoundedConductivity, so that the conductivity stays between its bounds. Once
/// it has converged the image is free of the linear model's bias, by which a disc of the ratio f
/// that is resolved has 2 / (1 + f) times its strength. The penalties are those of one-step-gn, the
/// smoothed total variation, and the Gaussian prior whose covariance is that of the training scenes
/// (of mean zero, as LinearMmse has it: no contact, no image).
class GaussNewton final : public Solver {
 public:
  static constexpr const char* type = "gauss-newton";

  /// `{"prior": "tikhonov" | "noser" | "laplace" | "total-variation" | "training", "lambda": > 0 |
  /// "auto", "bounds": [low, high], "tolerance", "max_iterations", "discrepancy", "calibrate"}` and
  /// what ChannelMask reads.
  explicit GaussNewton(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override;
  bool needs_training() const override { return prior_ == training; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  static constexpr const char* training = "training";
  static constexpr const char* total_variation = "total-variation";

  void read(JsonObject parameters);
  void set_sensor(const Sensor& sensor);
  /// E of ShapedPenalty; empty for penalties on edges.
  void set_shaping(const FitInput& input);
  void set_gains(const FitInput& input);
  void choose_lambda(const FitInput& input);
  std::unique_ptr<Penalty> penalty() const;

  std::string prior_;
  Tunable lambda_;
  GaussNewtonOptions options_;
  double low_ = 0;
  double high_ = 2;
  bool calibrate_ = false;
  std::optional<ParameterChoice> choice_;
  ChannelMask mask_;

  Sensor sensor_;
  BoundedConductivity bounds_;
  RowMajorMatrix background_jacobian_;  ///< [pairs, pixels], by ratios, V
  Eigen::MatrixXd shaping_;             ///< [pixels, 1] or [pixels, coordinates]
  Eigen::VectorXd gains_;               ///< [channels] that changes are multiplied with

  mutable std::mutex idle_mutex_;
  /// Iterations that no thread uses; a frame takes one and brings it back, warm.
  mutable std::vector<std::unique_ptr<GaussNewtonIteration>> idle_;
};

}  // namespace ertbench
