#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "core/random.h"
#include "forward/border/contact_electrodes.h"
#include "forward/data/scene_distribution.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// A scene by the random quantities that it was drawn from. The order of the contacts means
/// nothing.
using SceneDraw = std::vector<ContactDraw>;

/// What is known of a scene before its frame is seen: the distribution that a set's scenes are
/// drawn from, as a density that samplers can ask for.
class ScenePrior {
 public:
  /// Throws InputError for distributions with a "gap", whose contacts depend on each other.
  ScenePrior(const SceneDistribution& distribution, std::shared_ptr<const Sheet> sheet);

  const SceneDistribution& distribution() const { return distribution_; }
  const Sheet& sheet() const { return *sheet_; }
  /// As many contacts as are asked for, and else as this.
  ScenePrior with_contacts(std::size_t contacts) const;

  SceneDraw draw(RandomStream& random) const {
    return distribution_.draw_contacts(random, *sheet_);
  }
  ContactDraw draw_contact(RandomStream& random) const {
    return distribution_.draw_contact(random, *sheet_);
  }

  /// Logarithm of the probability of so many contacts; -infinity where there are never so many.
  double log_count(std::size_t contacts) const;
  /// Logarithm of the density of one contact, in the product of its free quantities; what has one
  /// value alone has no density. -infinity outside of what may be drawn.
  double log_density(const ContactDraw& contact) const;
  /// Of all its quantities but size and place.
  double log_form_density(const ContactDraw& contact) const;
  /// Of a whole scene, its contacts in a given order.
  double log_density(const SceneDraw& scene) const;

  bool size_is_free() const { return distribution_.radius.first < distribution_.radius.second; }
  bool ratio_is_free() const {
    return distribution_.conductivity_ratio.first < distribution_.conductivity_ratio.second;
  }
  /// Whether densities under both are of the same free quantities, so that samples of one may be
  /// weighted into samples of the other.
  bool is_comparable(const ScenePrior& other) const;

 private:
  SceneDistribution distribution_;
  std::shared_ptr<const Sheet> sheet_;
  double log_constant_ = 0;  ///< of log_form_density, all but corners
};

Scene scene_of(const SceneDraw& drawn);

/// The area of the part of a sheet that is at least `margin` from its border; of rectangles, and of
/// sheets whose insets are of their own shape, as the disc's are.
double inset_area(const Sheet& sheet, double margin);

/// Area of a contact, domain units squared.
double area_of(const ContactDraw& contact);

/// What a contact changes the field by, to first order in its size: area times 2 (1 - f) / (1 + f),
/// with the sign of the missing conductivity.
double strength_of(const ContactDraw& contact);

/// How sharply voltages tell where a small contact is and how strong: what steps of a random walk
/// are sized by. An approximation that costs nothing: samplers stay exact whatever it is.
class PlaceMetric {
 public:
  /// From the voltage changes of small discs, solved once at the centre of every pixel of a coarse
  /// grid, by the border model. `channel_noise` V.
  PlaceMetric(const Sensor& sensor, double channel_noise);
  /// The same everywhere: `precision` of a contact of strength 1.
  explicit PlaceMetric(const Eigen::Matrix3d& precision);

  /// The Fisher information of (x, y, log size) of a contact, by its place and strength.
  Eigen::Matrix3d information(const ContactDraw& contact) const;

 private:
  Eigen::AlignedBox2d box_;
  int columns_ = 1;
  int rows_ = 1;
  std::vector<Eigen::Matrix3d> precision_;  ///< [rows * columns], of (x, y, strength) at strength 1
};

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
