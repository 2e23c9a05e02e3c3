#pragma once

#include <array>
#include <optional>

#include "bench/limit/place_metric.h"
#include "bench/limit/scene_prior.h"
#include "core/random.h"

namespace ertbench {

/// Steps from a scene to another for Metropolis-Hastings-Green sampling (Green 1995).
enum class Move {
  walk,      ///< of a contact's place and size, by PlaceMetric
  exchange,  ///< of size against conductivity, the strength kept
  form,      ///< of angle, aspect and corners, the area kept
  reshape,   ///< another shape with angle, aspect and corners of its own, the area kept
  birth,     ///< of a contact drawn from the prior, or the death of one
  split,     ///< of a contact into two of the same strength together, or the merging of two
  joint,     ///< of all contacts (JointStep)
};
inline constexpr int move_count = 7;

/// A scene that a move leads to.
struct Proposal {
  SceneDraw scene;
  /// log [q(back) / q(forth) |Jacobian|]: what the ratio of the targets is multiplied by.
  double log_ratio = 0;
};

/// The moves' widths, 1 by themselves, which samplers adapt.
using MoveScales = std::array<double, move_count>;

class SceneMoves {
 public:
  /// Both must outlive this.
  SceneMoves(const ScenePrior& prior, const PlaceMetric& metric) : prior_(prior), metric_(metric) {}

  /// One of the moves, each as often as it is worth: any but the joint step, which is the
  /// sampler's.
  Move choose(RandomStream& random) const;

  /// Nothing where the move cannot be made. `heat`: the power of the likelihood in the target,
  /// 0 ... 1.
  std::optional<Proposal> propose(Move move, const SceneDraw& scene, double scale, double heat,
                                  RandomStream& random) const;

 private:
  std::optional<Proposal> walk(const SceneDraw& scene, double scale, double heat,
                               RandomStream& random) const;
  std::optional<Proposal> exchange(const SceneDraw& scene, double scale,
                                   RandomStream& random) const;
  std::optional<Proposal> form(const SceneDraw& scene, double scale, RandomStream& random) const;
  std::optional<Proposal> reshape(const SceneDraw& scene, RandomStream& random) const;
  std::optional<Proposal> birth(const SceneDraw& scene, RandomStream& random) const;
  std::optional<Proposal> death(const SceneDraw& scene, RandomStream& random) const;
  std::optional<Proposal> split(const SceneDraw& scene, RandomStream& random) const;
  std::optional<Proposal> merge(const SceneDraw& scene, RandomStream& random) const;

  /// Gives a contact the size at which it has `area`, where sizes are free; the logarithm of the
  /// derivative of the new size by the old one.
  double keep_area(double area, ContactDraw& contact) const;
  const ScenePrior& prior_;
  const PlaceMetric& metric_;
};

}  // namespace ertbench
