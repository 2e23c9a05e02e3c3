#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "forward/border/elliptic_contact.h"
#include "forward/sheet/sheet.h"
#include "solvers/contacts/contact_prior.h"

namespace ertbench {

/// Where contacts (EllipticContact, domain units) may be: on the sheet, a hair from its border,
/// neither larger nor longer than any contact is. The border is a constraint on the steps of a fit.
/// A contact that touches it slides along; were it only put back after each step, it would come to
/// its best place in many small ones.
class ContactBounds {
 public:
  /// `ellipses`: false for contacts that are discs and stay so.
  ContactBounds(const Sheet& sheet, const ContactPrior& prior, bool ellipses);

  /// Puts a contact back to where it may be.
  void keep_inside(EllipticContact& contact) const;

  /// The step s from `contacts` that makes g's + 1/2 s'Hs least, `gradient` g [6 contacts] and the
  /// factored `curvature` H, and leaves no contact beyond the sheet's border: constraints that it
  /// would break are linearised where it breaks them, and hold with equality.
  Eigen::VectorXd step(std::span<const EllipticContact> contacts,
                       const Eigen::LLT<Eigen::MatrixXd>& curvature,
                       const Eigen::VectorXd& gradient) const;

 private:
  /// The point of a contact that is nearest to the sheet's border, or farthest beyond it.
  struct Nearest {
    Eigen::Vector2d point;    ///< from the contact's centre
    Eigen::Vector2d inwards;  ///< unit normal of the border there
    double depth = 0;
  };
  /// Nothing where all of the contact is inside.
  std::optional<Nearest> outside(const EllipticContact& contact) const;

  const Sheet* sheet_;
  bool ellipses_;
  double longest_;  ///< EllipticContact::stretch
  double least_log_ratio_, largest_log_ratio_;
};

}  // namespace ertbench
