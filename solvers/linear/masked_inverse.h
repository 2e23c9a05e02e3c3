#pragma once

#include <Eigen/Core>
#include <map>
#include <mutex>
#include <string>
#include <vector>

namespace ertbench {

/// The matrix R^T R of (A4), as in EIDORS: the identity; diag(J^T J)^(1/2) (NOSER); twice the
/// Laplacian of the pixel graph, pixels being neighbours across an edge.
enum class Prior { tikhonov, noser, laplace };

Prior prior_from_name(const std::string& name);  ///< "tikhonov", "noser", "laplace"
const char* name_of(Prior prior);

/// Factored form of the prior: the image is E y + c 1 with |R (E y + c 1)| = |y|. The constant c is
/// free if R^T R maps constant images to zero, else 0.
struct PriorFactors {
  Eigen::MatrixXd shaping;  ///< E [pixels, number of y]
  bool free_constant;
};

/// For J [m, pixels]; `columns` of the image.
PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns);

/// A linear solver's image of one frame by itself, where that is no fixed matrix times the frame.
class FrameInverse {
 public:
  virtual ~FrameInverse() = default;

  /// The image [pixels] of d' [pairs] without the pairs `lost`, ascending. `noise`: variance of d'
  /// by noise, V^2, 0 if it is unknown.
  virtual Eigen::VectorXd image(Eigen::VectorXd means, const std::vector<Eigen::Index>& lost,
                                double noise) const = 0;
};

/// An inverse in the eigenvectors U, with the values w, of what explains d' besides noise of the
/// variance n,
///
///     image = basis (w + n)^-1 U^T d' + constant . d'.
///
/// Without the pairs l it is exactly that of the same solver for the others. The inverse of a block
/// of a matrix is that of P = U (w + n)^-1 U^T, with l eliminated: as if they had the values
/// -P_ll^-1 (P d')_l, which leave no trace there. A frame costs a system of the size of l, or of
/// the other pairs where those are fewer or U does not span all.
class SpectralInverse final : public FrameInverse {
 public:
  /// One-step Gauss-Newton from J' [pairs, pixels], from a singular value decomposition of J' E,
  /// which avoids its squared condition; w its squared values. A constant image that the prior
  /// ignores explains what lies along its data k = J' 1, the rest is orthogonal to that.
  SpectralInverse(const Eigen::MatrixXd& jacobian, const PriorFactors& prior);
  /// LinearMmse from its moments; `added` variance beside them.
  SpectralInverse(const Eigen::MatrixXd& changes, const Eigen::MatrixXd& cross, double added);

  /// Makes n follow the noise of a frame: at that of `changes` it is the noise in them and what was
  /// added, else in proportion. The noise in them is that of their weakest directions.
  void follow_noise();
  void set_noise(double variance) { noise_ = variance; }
  double largest_power() const { return powers_.maxCoeff(); }
  /// The whole as a matrix [pixels, pairs], for its own noise.
  Eigen::MatrixXd matrix() const;

  Eigen::VectorXd image(Eigen::VectorXd means, const std::vector<Eigen::Index>& lost,
                        double noise) const override;

 private:
  /// (w + n)^-1, finite where both are lost by underflow, as basis is then.
  Eigen::VectorXd weights(double noise) const {
    return (powers_.array() + noise).max(1e-300).inverse();
  }

  Eigen::VectorXd image_of_live(const Eigen::VectorXd& means, const std::vector<Eigen::Index>& live,
                                double variance) const;

  Eigen::MatrixXd directions_;   ///< U [pairs, n]
  Eigen::VectorXd powers_;       ///< w
  Eigen::MatrixXd basis_;        ///< [pixels, n]
  Eigen::RowVectorXd constant_;  ///< [pairs], empty where there is none
  double noise_ = 0;
  double usual_ = 0;  ///< noise of a frame at which noise_ holds; 0: at any
};

/// Truncated singular value decomposition of J'_kept, from the eigenvectors of its Gram matrix.
/// Values below `least` are dropped, so that noise is amplified no more than with all pairs. What
/// is left of a truncation follows from no small system: each set of pairs has a matrix, which is
/// kept for the sets met last.
class MaskedTsvd final : public FrameInverse {
 public:
  /// J' [pairs, pixels].
  MaskedTsvd(const Eigen::MatrixXd& jacobian, double least);
  Eigen::VectorXd image(Eigen::VectorXd means, const std::vector<Eigen::Index>& lost,
                        double noise) const override;

 private:
  /// C [pairs, pairs], zero in the rows and columns of the lost ones.
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& lost) const;

  Eigen::MatrixXd basis_;
  Eigen::MatrixXd gram_;
  double least_;
  mutable std::mutex mutex_;
  mutable std::map<std::vector<Eigen::Index>, Eigen::MatrixXd> weights_;
};

}  // namespace ertbench
