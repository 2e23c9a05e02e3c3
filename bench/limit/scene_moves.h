#pragma once

#include <array>
#include <optional>

#include "bench/limit/place_metric.h"
#include "bench/limit/scene_prior.h"
#include "core/random.h"
#include "forward/border/elliptic_contact.h"

namespace ertbench {

/// Steps from a scene to another of as many contacts, for Metropolis-Hastings sampling. Where a
/// contact's form changes, the centre and area of its nearest ellipse stay, which is what voltages
/// tell first.
enum class Move {
  walk,      ///< of a contact's place and size, by PlaceMetric
  exchange,  ///< of size against conductivity, the strength kept
  form,      ///< of angle and aspect, or of one corner
  reshape,   ///< another shape, with the angle and aspect that there are or with its own
  redraw,    ///< a contact drawn anew from the prior
  joint,     ///< of all contacts (JointStep)
};
inline constexpr int move_count = 6;

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
  std::optional<Proposal> redraw(const SceneDraw& scene, RandomStream& random) const;

  /// Gives a contact the size and place at which its nearest ellipse has the area and centre of
  /// `before`, as far as these are free; the logarithm of the derivative of the new size by the old
  /// one.
  double keep_ellipse(const EllipticContact& before, ContactDraw& contact) const;
  const ScenePrior& prior_;
  const PlaceMetric& metric_;
};

}  // namespace ertbench
