#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "solvers/channel_mask.h"
#include "solvers/iterated/sheet_operator.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

struct GaussNewtonOptions {
  double tolerance = 1e-2;  ///< stops at this relative change of the image
  int max_iterations = 20;
  /// If > 0, stops as soon as the misfit is at most this many times the noise of the frame, which
  /// is estimated from the differences between reciprocal channels.
  double discrepancy = 0;
};

/// The Gauss-Newton iteration for one frame,
///
///     min over z of 1/2 |F(t(z)) - d'|^2 + penalty(z),
///
/// with the change F of the grid model's voltages. Each step minimises with F linearised at the
/// last image and is halved until it lowers the objective. Holds the working memory of one thread;
/// the result of a frame does not depend on earlier frames.
class GaussNewtonIteration {
 public:
  /// `background_jacobian` [pairs, pixels] V: derivatives of d' with respect to conductivity /
  /// background at the uniform sheet. It must outlive the iteration.
  GaussNewtonIteration(const Sensor& sensor, const BoundedConductivity& bounds,
                       std::unique_ptr<Penalty> penalty, const RowMajorMatrix& background_jacobian);

  /// `change` [channels] V, `image` [pixels] S/m. Uses the pairs `kept`. A frame that is not finite
  /// gives a zero image and the status undefined.
  void minimise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                const std::vector<Eigen::Index>& kept, const GaussNewtonOptions& options,
                Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report);

  /// The objective, V^2, at the end of the last frame.
  double objective() const { return objective_; }

 private:
  /// Sets the sheet to the image of `z` and returns the objective.
  double set(const Eigen::VectorXd& z, const std::vector<Eigen::Index>& kept);
  double noise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
               const std::vector<Eigen::Index>& kept) const;

  Reciprocity reciprocity_;
  double background_;
  SheetOperator sheet_;
  BoundedConductivity bounds_;
  std::unique_ptr<Penalty> penalty_;
  const RowMajorMatrix& background_jacobian_;
  double objective_ = 0;

  Eigen::VectorXd data_, modelled_, residual_, linear_;         // [kept]
  Eigen::VectorXd z_, best_, trial_;                            // [coordinates]
  Eigen::VectorXd t_, t_trial_, ratio_, ratio_before_, slope_;  // [pixels]
  RowMajorMatrix jacobian_;                                     // [kept, pixels]
};

/// Iterated Gauss-Newton reconstruction: fits the voltages of the nonlinear grid model to the
/// changes, with a penalty on the image,
///
///     min over t of 1/2 |F(t) - changes|^2 + penalty(t),
///
/// where t is the variable of BoundedConductivity, which keeps the conductivity between its bounds.
/// A converged image is free of the bias of the linear model, in which a resolved disc of ratio f
/// has 2 / (1 + f) times its strength. Penalties are those of one-step-gn, the smoothed total
/// variation, and a Gaussian prior of mean zero with the covariance of the training scenes.
class GaussNewton final : public Solver {
 public:
  static constexpr const char* type = "gauss-newton";

  /// `{"prior": "tikhonov" | "noser" | "laplace" | "total-variation" | "training", "lambda": > 0 |
  /// "auto", "bounds": [low, high], "tolerance", "max_iterations", "discrepancy", "calibrate"}` and
  /// the key of ChannelMask.
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
  ChannelMask mask_;

  Sensor sensor_;
  BoundedConductivity bounds_;
  RowMajorMatrix background_jacobian_;  ///< [pairs, pixels] V, see GaussNewtonIteration
  Eigen::MatrixXd shaping_;             ///< [pixels, 1] or [pixels, coordinates]
  Eigen::VectorXd gains_;               ///< [channels] factors on the changes

  mutable std::mutex idle_mutex_;
  /// Pool of iterations; a call takes one and returns it with its memory.
  mutable std::vector<std::unique_ptr<GaussNewtonIteration>> idle_;
};

/// The solvers of this room, for the registry.
std::vector<SolverType> iterated_solvers();

}  // namespace ertbench
