#pragma once

#include <Eigen/Core>

#include "solvers/decompositions.h"
#include "solvers/linear/linear_solver.h"
#include "solvers/parameter_choice.h"

namespace ertbench {

/// The singular triplets of `a` up to its rank: values above 1e-13 of the largest. Errors are of
/// the order of rounding in the largest value.
DenseSvd singular_triplets(const Eigen::MatrixXd& a);

/// Truncated singular value decomposition, as EIDORS's inv_solve_TSVD: with J = sum s_i u_i v_i^T
/// at the uniform background, s descending,
///
///     image = sum_{i <= rank} v_i (u_i^T changes) / s_i .
///
/// Reciprocity leaves J a rank of at most channels / 2; a higher one would divide noise by zero and
/// is refused. The symmetries of the sensor make singular values double: with a rank that splits
/// such a pair the image depends on rounding. "auto" and thresholds keep pairs whole; a given rank
/// that splits one is used with a warning.
///
/// The image is computed as [v_i] ([u_i^T / s_i] changes) if that is less work than the product of
/// the two matrices: for d2s up to rank 88.
class TruncatedSvd final : public LinearSolver {
 public:
  static constexpr const char* type = "tsvd";

  /// `{"rank": >= 1 | "auto"}` or `{"threshold": in (0, 1) | "auto"}`: singular values down to
  /// `threshold` times the largest are kept. Without either, `"rank": "auto"`. Also the keys of
  /// LinearInference and ChannelMask.
  explicit TruncatedSvd(JsonObject parameters);

  void check(const Sensor& sensor) const override;
  void fit(const FitInput& input) override;

 private:
  void read(JsonObject parameters) override;
  nlohmann::json fit_parameters() const override;
  void save_fit(Hdf5File& file) const override;
  void load_fit(const Hdf5File& file, const Sensor& sensor) override;
  void truncate(const FitInput& input);
  std::unique_ptr<const FrameInverse> frame_inverse() const override;
  void set_rank(const DenseSvd& triplets, Eigen::Index rank);
  Eigen::Index choose_rank(const FitInput& input, const DenseSvd& triplets);

  bool by_rank_ = true;
  Tunable cut_;            ///< the rank or the threshold
  double least_kept_ = 0;  ///< singular value of J, V per S/m
};

}  // namespace ertbench
