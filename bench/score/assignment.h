#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace ertbench {

/// A one-to-one assignment of the members of the smaller of two sets to those of the larger.
struct Assignment {
  /// (row, column) of the pairs that are at most the cut-off apart, by row.
  std::vector<std::array<int, 2>> pairs;
  double cost = 0;  ///< the minimised sum
};

/// Minimises the sum of min(distance, cutoff) over the members of the smaller set, by shortest
/// augmenting paths (Jonker and Volgenant 1987), in O(n² m). `distances` [n, m] of any shape, >= 0;
/// NaN counts as beyond the cut-off. Members assigned beyond the cut-off cost the cut-off and form
/// no pair. The number of pairs is not maximised: one pair at distance 0 costs less than two pairs
/// at more than half the cut-off.
Assignment assign(const Eigen::Ref<const Eigen::MatrixXd>& distances, double cutoff);

/// Distances [a, b] between the positions of two sets.
Eigen::MatrixXd distances_between(std::span<const Eigen::Vector2d> a,
                                  std::span<const Eigen::Vector2d> b);

/// Optimal sub-pattern assignment distance of order 1 between two sets of positions (Schuhmacher,
/// Vo and Vo 2008, equation 3): for n positions and m >= n others
///
///     (sum over the n of min(distance, cutoff), assigned for the least sum, + cutoff (m - n)) / m
///
/// in the unit of the positions: a mean distance in which a surplus or missing position counts
/// `cutoff`. 0 if both sets are empty, `cutoff` if one of them is.
double ospa(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double cutoff);

}  // namespace ertbench
