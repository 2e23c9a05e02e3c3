#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "forward/border/contact_electrodes.h"
#include "forward/ellipses/ellipse_model.h"
#include "solvers/contacts/contact_prior.h"

namespace ertbench {

/// Share of a step [parameters * contacts] that stays within the longest step of every parameter.
double step_share(const Eigen::VectorXd& step);

/// The contacts after step_share of a step [parameters * contacts].
std::vector<EllipticContact> moved(std::span<const EllipticContact> contacts,
                                   const Eigen::VectorXd& step);

/// Merges two contacts: joint area and second moments, mean log ratio.
EllipticContact joined(const EllipticContact& a, const EllipticContact& b);

/// Splits contact `k` in two along its longer axis; the second part comes last.
std::vector<EllipticContact> with_split(std::span<const EllipticContact> contacts, std::size_t k);

/// Dictionary of starting points: discs all over the sheet, in some sizes and one ratio, with their
/// voltages. The voltages of a disc are nearly proportional to its dipole strength
/// (1 - f) / (1 + f), so that the amplitude of the best atom gives the ratio f.
class ContactAtoms {
 public:
  /// `whitening` [pairs, pairs] scales changes to unit noise.
  ContactAtoms(const EllipseModel& model, const Eigen::MatrixXd& whitening);

  struct Start {
    EllipticContact contact;
    double gain = 0;  ///< gain of the log likelihood if the voltages were linear
  };
  /// The best `count` atoms for a whitened residual [pairs] with `weights` [pairs], best first.
  /// None lies within half its size of another's centre, and all have signs that the prior allows.
  void best(const Eigen::VectorXd& residual, const Eigen::VectorXd& weights, int count,
            const ContactPrior& prior, std::vector<Start>& out) const;

  Eigen::Index size() const { return atoms_.rows(); }

 private:
  std::vector<EllipticContact> contacts_;
  Eigen::MatrixXf atoms_;    ///< [atoms, pairs] whitened
  Eigen::MatrixXf squares_;  ///< [atoms, pairs] squares of `atoms_`
};

}  // namespace ertbench
