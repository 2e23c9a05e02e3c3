#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/arrays.h"
#include "solvers/iterated/bounded_conductivity.h"
#include "solvers/iterated/penalty.h"
#include "solvers/iterated/sheet_operator.h"
#include "solvers/reciprocity.h"
#include "solvers/solver.h"

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

}  // namespace ertbench
