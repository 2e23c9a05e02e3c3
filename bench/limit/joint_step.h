#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "bench/limit/scene_likelihood.h"
#include "bench/limit/scene_prior.h"
#include "core/random.h"
#include "forward/ellipses/ellipse_model.h"

namespace ertbench {

/// Steps of all contacts of a scene together, along what the frame's rest asks for and as wide as
/// the frame allows: the Metropolis-adjusted Langevin step in the metric of the Fisher information,
/// simplified (Girolami and Calderhead 2011). Its slopes are those of the ellipses nearest to the
/// contacts, so that a step costs a small part of a forward solution; that they are not the slopes
/// of the contacts themselves costs acceptance and nothing else.
///
/// One object serves one thread.
class JointStep {
 public:
  /// All must outlive this.
  JointStep(const ScenePrior& prior, const EllipseModel& model);

  /// The normal distribution of the steps from a scene.
  struct Local {
    Eigen::VectorXd mean;
    Eigen::LLT<Eigen::MatrixXd> precision;

    Eigen::VectorXd draw(RandomStream& random) const;
    double log_density(const Eigen::VectorXd& step) const;  ///< up to a constant of its length
  };

  /// From `scene`, which explains its frame as `fit` says. `heat`: the power of the likelihood in
  /// the target, 0 ... 1; `scale`: of the steps, 1 for those as wide as the target. Nothing where
  /// the fit has no rest, or an ellipse crosses the sheet's border.
  std::optional<Local> around(const SceneDraw& scene, const SceneFit& fit, double heat,
                              double scale);
  /// The scene after a step, and the logarithm of the derivative of its sizes by their logarithms
  /// over that before it.
  std::pair<SceneDraw, double> after(const SceneDraw& scene, const Eigen::VectorXd& step) const;

 private:
  /// [pairs, quantities] V per unit; `ellipses` [contacts] are the scene's. Nothing where one of
  /// them crosses the sheet's border.
  std::optional<Eigen::MatrixXd> slopes_of(const SceneDraw& scene,
                                           std::span<const EllipticContact> ellipses);
  /// By the parameters of the ellipses together; false where they cross.
  bool slopes_of(std::span<const EllipticContact> ellipses, Eigen::Ref<Eigen::MatrixXd> out);

  const ScenePrior& prior_;
  const EllipseModel& model_;
  std::vector<std::array<int, 2>> pairs_;
  EllipseModel::Workspace workspace_;
};

}  // namespace ertbench
