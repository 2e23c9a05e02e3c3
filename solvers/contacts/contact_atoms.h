#pragma once

#include <Eigen/Core>
#include <vector>

#include "forward/ellipses/ellipse_model.h"
#include "solvers/contacts/contact_prior.h"

namespace ertbench {

/// Discs all over the sheet, of some sizes and one ratio, and what each does to the voltages: where
/// a fit begins. The dipole strength (1 - f) / (1 + f) of a disc and its voltages are nearly
/// proportional, so that the amplitude of the best atom says the ratio.
class ContactAtoms {
 public:
  /// `whitening` [pairs, pairs] takes changes to units of their noise.
  ContactAtoms(const EllipseModel& model, const Eigen::MatrixXd& whitening);

  struct Start {
    EllipticContact contact;
    double gain = 0;  ///< of the log likelihood, were the voltages linear
  };
  /// The best `count` atoms for a whitened residual [pairs] that counts by `weights` [pairs], none
  /// within half its own size of another's centre, the best first; of the signs that the prior
  /// allows.
  void best(const Eigen::VectorXd& residual, const Eigen::VectorXd& weights, int count,
            const ContactPrior& prior, std::vector<Start>& out) const;

  Eigen::Index size() const { return atoms_.rows(); }

 private:
  std::vector<EllipticContact> contacts_;
  Eigen::MatrixXf atoms_;    ///< [atoms, pairs] whitened
  Eigen::MatrixXf squares_;  ///< [atoms, pairs] theirs
};

}  // namespace ertbench
