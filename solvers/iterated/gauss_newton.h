#pragma once

#include <Eigen/Core>
#include <memory>
#include <mutex>
#include <optional>
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
  double tolerance = 1e-2;  ///< relative change of the image at which a frame is done
  int max_iterations = 20;
  /// Above 0: done as soon as the misfit is this many times the frame's noise, which is known from
  /// what reciprocal channels differ by.
  double discrepancy = 0;
};

/// The Gauss-Newton iteration for one frame,
///
///     min over z of 1/2 |F(t(z)) - d'|^2 + penalty(z),
///
/// F the change of the grid model's voltages. Every step minimises with F linearised at the last
/// image, and is halved until it lowers the objective itself. Holds the working memory of one
/// thread; the result of a frame does not depend on those before.
class GaussNewtonIteration {
 public:
  /// `background_jacobian` [pairs, pixels]: d' by the ratios of conductivities, of the uniform
  /// sheet; it outlives the iteration.
  GaussNewtonIteration(const Sensor& sensor, const BoundedConductivity& bounds,
                       std::unique_ptr<Penalty> penalty, const RowMajorMatrix& background_jacobian);

  /// `change` [channels] V, `image` [pixels] S/m. The pairs `kept` count. A frame that is not
  /// finite gives a zero image and the status undefined.
  void minimise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                const std::vector<Eigen::Index>& kept, const GaussNewtonOptions& options,
                Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report);

  /// The objective, V^2, at the end of the last frame.
  double objective() const { return objective_; }

 private:
  /// Sets the sheet to the image of `z`, and returns the objective there.
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

/// The solvers of this folder, for the registry.
std::vector<SolverType> iterated_solvers();

}  // namespace ertbench
