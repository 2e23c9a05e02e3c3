#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "forward/border/elliptic_contact.h"

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

}  // namespace ertbench
