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

/// J [m, pixels] -> R^T R [pixels, pixels]; `columns` of the image, 0 of a square one.
Eigen::MatrixXd prior_matrix(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

/// The same by its factors: the image is E y + c 1 with |R(E y + c 1)| = |y|; c only where R^T R
/// maps constant images to zero.
struct PriorFactors {
  Eigen::MatrixXd shaping;  ///< E [pixels, number of y]
  bool free_constant;
};

PriorFactors prior_factors(Prior prior, const Eigen::MatrixXd& jacobian, int columns = 0);

/// A linear solver's inverse where only some reciprocal pairs count, in measurement space: all that
/// has the size of the image is computed once, a set of pairs costs one small decomposition,
///
///     image = basis C d',   C zero in the columns of pairs that do not count.
class MaskedInverse {
 public:
  virtual ~MaskedInverse() = default;

  /// [pixels, rows of C]
  const Eigen::MatrixXd& basis() const { return basis_; }
  /// C [columns of the basis, pairs]; `kept` pairs ascending.
  virtual Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const = 0;

 protected:
  Eigen::MatrixXd basis_;
};

/// One-step Gauss-Newton: with the images E y + c 1 of PriorFactors, S = J' E and k = J' 1,
///
///     M = S_kept S_kept^T + lambda^2,   y = S_kept^T M^-1 (d' - c k),   c = k^T M^-1 d' / k^T M^-1
///     k,
///
/// c only where the prior leaves it free. One Cholesky decomposition.
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

/// Truncated singular value decomposition of J'_kept, from the eigenvectors of its Gram matrix:
/// values down to `least` count, as many as of J' or fewer, so that noise is amplified no more.
class MaskedTsvd final : public MaskedInverse {
 public:
  MaskedTsvd(const Eigen::MatrixXd& jacobian, double least);
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const override;

 private:
  Eigen::MatrixXd gram_;
  double least_;
};

/// The linear estimate of least mean squared error (LinearMmse) from the kept pairs alone, which is
/// exact: their moments are a part of all. One Cholesky decomposition.
class MaskedMmse final : public MaskedInverse {
 public:
  /// Second moments [pairs, pairs] and [pixels, pairs], ridge as mmse_matrix has them.
  MaskedMmse(Eigen::MatrixXd changes, const Eigen::MatrixXd& cross, double ridge);
  Eigen::MatrixXd weights(const std::vector<Eigen::Index>& kept) const override;

 private:
  Eigen::MatrixXd changes_;
  double ridge_;
};

}  // namespace ertbench
