#pragma once

#include <memory>
#include <vector>

#include "forward/data/scene_distribution.h"

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

}  // namespace ertbench
