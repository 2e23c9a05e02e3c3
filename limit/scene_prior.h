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

/// The random quantities of a scene. The order of the contacts has no meaning.
using SceneDraw = std::vector<ContactDraw>;

/// The prior of scenes: the distribution that a set's scenes are drawn from, with its density.
class ScenePrior {
 public:
  /// Throws InputError for distributions with a "gap", whose contacts depend on each other.
  ScenePrior(const SceneDistribution& distribution, std::shared_ptr<const Sheet> sheet);

  const SceneDistribution& distribution() const { return distribution_; }
  const Sheet& sheet() const { return *sheet_; }
  /// A copy with a fixed number of contacts.
  ScenePrior with_contacts(std::size_t contacts) const;

  SceneDraw draw(RandomStream& random) const {
    return distribution_.draw_contacts(random, *sheet_);
  }
  ContactDraw draw_contact(RandomStream& random) const {
    return distribution_.draw_contact(random, *sheet_);
  }

  /// Log probability of a number of contacts; -infinity if it cannot occur.
  double log_count(std::size_t contacts) const;
  /// Log density of one contact in its free quantities; -infinity outside the support.
  double log_density(const ContactDraw& contact) const;
  /// Log density of all its quantities but size and position.
  double log_form_density(const ContactDraw& contact) const;
  /// Log density of a whole scene with its contacts in a given order.
  double log_density(const SceneDraw& scene) const;

  bool size_is_free() const { return distribution_.radius.first < distribution_.radius.second; }
  bool ratio_is_free() const {
    return distribution_.conductivity_ratio.first < distribution_.conductivity_ratio.second;
  }
  /// True if both have the same free quantities, so that samples may be reweighted.
  bool is_comparable(const ScenePrior& other) const;

 private:
  SceneDistribution distribution_;
  std::shared_ptr<const Sheet> sheet_;
  double log_constant_ = 0;  ///< log_form_density without corners
};

Scene scene_of(const SceneDraw& drawn);

/// Area of the part of a sheet that is at least `margin` from its border, for rectangles and for
/// sheets whose insets have their own shape, like the disc.
double inset_area(const Sheet& sheet, double margin);

/// Area of a contact, domain units squared.
double area_of(const ContactDraw& contact);

/// A contact's effect on the field to first order in its size: area times 2 (1 - f) / (1 + f),
/// positive where conductivity is missing.
double strength_of(const ContactDraw& contact);

/// Approximate Fisher information of the position and size of a small contact, which sets the steps
/// of random walks. Samplers are exact whatever its values.
class PlaceMetric {
 public:
  /// Computed from the voltage changes of small discs at the pixels of a coarse grid, by the border
  /// model. `channel_noise` V.
  PlaceMetric(const Sensor& sensor, double channel_noise);
  /// Uniform over the sheet: `precision` of a contact of strength 1.
  explicit PlaceMetric(const Eigen::Matrix3d& precision);

  /// Information of (x, y, log size) of a contact.
  Eigen::Matrix3d information(const ContactDraw& contact) const;

 private:
  Eigen::AlignedBox2d box_;
  int columns_ = 1;
  int rows_ = 1;
  std::vector<Eigen::Matrix3d> precision_;  ///< [rows * columns], of (x, y, strength) at strength 1
};

/// Metropolis-Hastings moves, all but `number` and `split` between scenes with the same number of
/// contacts. Changes of a contact's form keep the centre and area of its nearest ellipse, which
/// voltages determine best.
enum class Move {
  walk,      ///< position and size of a contact change, by PlaceMetric
  exchange,  ///< size is traded for conductivity at constant strength
  form,      ///< angle and aspect, or one corner, change
  reshape,   ///< another shape, with the old or a new angle and aspect
  redraw,    ///< a contact is drawn anew from the prior
  joint,     ///< all contacts move (JointStep)
  number,    ///< a contact drawn from the prior is added, or one is taken away
  split,     ///< a contact becomes two of the same strength and centre together, or two become one
};
inline constexpr int move_count = 8;

struct Proposal {
  SceneDraw scene;
  /// log [q(back) / q(forth) |Jacobian|], which multiplies the ratio of the targets.
  double log_ratio = 0;
};

/// Factors on the moves' widths, which samplers adapt.
using MoveScales = std::array<double, move_count>;

class SceneMoves {
 public:
  /// Both must outlive this.
  SceneMoves(const ScenePrior& prior, const PlaceMetric& metric) : prior_(prior), metric_(metric) {}

  /// Draws one of the moves but the joint step and those that change the number, which the sampler
  /// chooses.
  Move choose(RandomStream& random) const;

  /// Nothing if the move is impossible. `heat`: the power of the likelihood in the target, 0 ... 1.
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
  std::optional<Proposal> number(const SceneDraw& scene, RandomStream& random) const;
  std::optional<Proposal> split(const SceneDraw& scene, RandomStream& random) const;

  /// Gives a contact the size and position at which its nearest ellipse has the area and centre of
  /// `before`, as far as these are free. Returns the log derivative of the new size by the old.
  double keep_ellipse(const EllipticContact& before, ContactDraw& contact) const;

  const ScenePrior& prior_;
  const PlaceMetric& metric_;
};

}  // namespace ertbench
