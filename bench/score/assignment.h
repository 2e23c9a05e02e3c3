#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace ertbench {

/// Who is who in two sets: each member of the smaller set has one of the larger set to itself.
struct Assignment {
  /// (row, column) of the pairs that are at most the cut-off apart, by row.
  std::vector<std::array<int, 2>> pairs;
  double cost = 0;  ///< what was minimised
};

/// Minimises the sum of min(distance, cutoff) over the members of the smaller set, by shortest
/// augmenting paths (Jonker and Volgenant 1987), in O(n² m). `distances` [n, m] of any shape, not
/// negative; one that is not a number counts as beyond the cut-off. Pairs beyond the cut-off are no
/// pairs, and cost the cut-off, as does a member that is left alone: it does not matter whom they
/// were given. The number of pairs is not maximised for its own sake: one pair at distance 0 beats
/// two that are more than half a cut-off apart each.
Assignment assign(const Eigen::Ref<const Eigen::MatrixXd>& distances, double cutoff);

/// [a, b] distances between the places of two sets.
Eigen::MatrixXd distances_between(std::span<const Eigen::Vector2d> a,
                                  std::span<const Eigen::Vector2d> b);

/// Optimal sub-pattern assignment distance of order 1 between two sets of places (Schuhmacher, Vo
/// and Vo 2008, equation 3): of n places and m >= n others
///
///     (sum over the n of min(distance, cutoff), assigned for the least sum, + cutoff (m - n)) / m
///
/// in the places' own unit: a mean distance in which a place too many or too few is `cutoff` away.
/// 0 where both sets are empty, `cutoff` where one of them is.
double ospa(std::span<const Eigen::Vector2d> a, std::span<const Eigen::Vector2d> b, double cutoff);

}  // namespace ertbench
