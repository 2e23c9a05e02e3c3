#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "forward/border/contact_electrodes.h"
#include "forward/ellipses/ellipse_model.h"
#include "solvers/contacts/contact_prior.h"

namespace ertbench {

/// The part of a step [parameters * contacts] that is taken: all of it, unless it is too long for
/// any of the contacts.
double step_share(const Eigen::VectorXd& step);

/// The contacts a step [parameters * contacts] away, or that share of it.
std::vector<EllipticContact> moved(std::span<const EllipticContact> contacts,
                                   const Eigen::VectorXd& step);

/// The ellipse of two's joint area and second moments, of the mean of their log ratios.
EllipticContact joined(const EllipticContact& a, const EllipticContact& b);

/// The contacts with one of them in two parts along its longer axis, the second one the last.
std::vector<EllipticContact> with_split(std::span<const EllipticContact> contacts, std::size_t k);

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
