#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace ertbench {

/// The matrix R^T R of (A4), as in EIDORS: the identity; diag(J^T J)^(1/2) (NOSER); twice the
/// Laplacian of the pixel graph, pixels being neighbours across an edge.
enum class Prior { tikhonov, noser, laplace };

Prior prior_from_name(const std::string& name);  ///< "tikhonov", "noser", "laplace"
const char* name_of(Prior prior);

/// R^T R [pixels, pixels] for J [m, pixels]; `columns` of the image, 0 for a square one.
Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

/// Factored form of the prior: the image is E y + c 1 with |R (E y + c 1)| = |y|. The constant c is
/// free if R^T R maps constant images to zero, else 0.
struct PriorFactors {
  Eigen::MatrixXd shaping;  ///< E [pixels, number of y]
  bool free_constant;
};

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

/// A linear solver's inverse for a subset of the reciprocal pairs, in measurement space. Everything
/// of the size of the image is computed once; a subset costs one small decomposition,
///
///     image = basis C d',   C zero in the columns of the other pairs.
class MaskedInverse {
 public:
  virtual ~MaskedInverse() = default;

  /// [pixels, rows of C]
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// C [columns of the basis, pairs] for the pairs `kept`, ascending.
  virtual Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const = 0;

 protected:
  Eigen::MatrixXd basis_;
};

/// One-step Gauss-Newton: with the images E y + c 1 of PriorFactors, S = J' E and k = J' 1,
///
///     M = S_kept S_kept^T + lambda^2,   y = S_kept^T M^-1 (d' - c k),   c = k^T M^-1 d' / k^T M^-1
///     k,
///
/// with c = 0 unless the prior leaves it free. One Cholesky decomposition.
class MaskedGaussNewton final : public MaskedInverse {
 public:
  /// J' [pairs, pixels].
  MaskedGaussNewton(const Eigen::MatrixXd& jacobian, const PriorFactors& prior, double lambda);
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const override;

 private:
  Eigen::MatrixXd gram_;      ///< S S^T
  Eigen::VectorXd constant_;  ///< k, empty where there is no free constant
  double square_;             ///< lambda^2
};

/// Truncated singular value decomposition of J'_kept, from the eigenvectors of its Gram matrix.
/// Values below `least` are dropped, so that noise is amplified no more than with all pairs.
class MaskedTsvd final : public MaskedInverse {
 public:
  MaskedTsvd(const Eigen::MatrixXd& jacobian, double least);
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const override;

 private:
  Eigen::MatrixXd gram_;
  double least_;
};

/// The linear estimate of least mean squared error (LinearMmse) from the kept pairs. It is exact,
/// because their moments are a block of the moments of all pairs. One Cholesky decomposition.
class MaskedMmse final : public MaskedInverse {
 public:
  /// Second moments [pairs, pairs] and [pixels, pairs] and ridge as for mmse_matrix.
  MaskedMmse(Eigen::MatrixXd changes, const Eigen::MatrixXd& cross, double ridge);
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const override;

 private:
  Eigen::MatrixXd changes_;
  double ridge_;
};

}  // namespace ertbench
