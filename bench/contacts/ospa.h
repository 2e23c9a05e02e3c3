#pragma once

#include <Eigen/Core>
#include <span>

namespace ertbench {

/// Optimal sub-pattern assignment distance of order 1 between two sets of places (Schuhmacher, Vo
/// and Vo 2008, equation 3): of n places and m >= n others
///
///     (sum over the n of min(distance, cutoff), assigned for the least sum, + cutoff (m - n)) / m
///
/// in the places' own unit: a mean distance in which a place too many or too few is `cutoff` away.
/// 0 where both sets are empty, `cutoff` where one of them is.
double ospa(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double cutoff);

}  // namespace ertbench
