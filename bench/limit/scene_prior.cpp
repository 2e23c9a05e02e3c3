#include "bench/limit/scene_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/errors.h"

namespace ertbench {
namespace {

constexpr double never = -std::numeric_limits<double>::infinity();
constexpr double prior_rounding = 1e-12;  ///< of lengths, domain units

bool lies_in(const std::pair<double, double>& interval, double value) {
  return value >= interval.first - prior_rounding && value <= interval.second + prior_rounding;
}

double log_width(const std::pair<double, double>& interval) {
  return interval.first < interval.second ? std::log(interval.second - interval.first) : 0;
}

}  // namespace

ScenePrior::ScenePrior(const SceneDistribution& distribution, std::shared_ptr<const Sheet> sheet)
    : distribution_(distribution), sheet_(std::move(sheet)) {
  if (distribution.gap) {
    throw InputError(
        "the limit is not computed for scenes with a \"gap\", whose contacts depend on each other; "
        "name other sets by --dataset");
  }
  log_constant_ = -std::log(static_cast<double>(distribution.shapes.size())) -
                  log_width(distribution.conductivity_ratio) - log_width(distribution.aspect) -
                  std::log(std::numbers::pi);
}

ScenePrior ScenePrior::with_contacts(std::size_t contacts) const {
  SceneDistribution scenes = distribution_;
  const auto count = static_cast<int>(contacts);
  scenes.blank_fraction = count == 0 ? 1 : 0;
  if (count > 0) scenes.contacts = {count, count};
  return {scenes, sheet_};
}

double ScenePrior::log_count(std::size_t contacts) const {
  const double blank = distribution_.blank_fraction;
  const auto [least, most] = distribution_.contacts;
  const auto count = static_cast<int>(contacts);
  double probability = count == 0 ? blank : 0;
  if (count >= least && count <= most) probability += (1 - blank) / (most - least + 1);
  return probability > 0 ? std::log(probability) : never;
}

double ScenePrior::log_form_density(const ContactDraw& contact) const {
  const SceneDistribution& d = distribution_;
  if (std::find(d.shapes.begin(), d.shapes.end(), contact.shape) == d.shapes.end()) return never;
  if (!lies_in(d.aspect, contact.aspect) ||
      !lies_in(d.conductivity_ratio, contact.conductivity_ratio) || contact.angle < 0 ||
      contact.angle > std::numbers::pi) {
    return never;
  }
  if (contact.shape != DrawnShape::polygon) return log_constant_;
  const auto count = static_cast<int>(contact.corners.size());
  if (count < d.corners.first || count > d.corners.second) return never;
  for (const ContactDraw::Corner& corner : contact.corners) {
    if (std::abs(corner.turn) > corner_turn || corner.reach < 0 || corner.reach > 1) return never;
  }
  return log_constant_ - std::log(d.corners.second - d.corners.first + 1) -
         count * std::log(2 * corner_turn);
}

double ScenePrior::log_density(const ContactDraw& contact) const {
  const SceneDistribution& d = distribution_;
  const double log = log_form_density(contact) - log_width(d.radius);
  if (!lies_in(d.radius, contact.size)) return never;
  if (d.centre) {
    const auto& [x, y] = *d.centre;
    if (!lies_in(x, contact.centre.x()) || !lies_in(y, contact.centre.y())) return never;
    return log - log_width(x) - log_width(y);
  }
  const double margin = d.inside ? contact.size : 0;
  if (sheet_->depth(contact.centre) < margin - prior_rounding) return never;
  return log - std::log(inset_area(*sheet_, margin));
}

double ScenePrior::log_density(const SceneDraw& scene) const {
  double log = log_count(scene.size());
  for (const ContactDraw& contact : scene) log += log_density(contact);
  return log;
}

bool ScenePrior::is_comparable(const ScenePrior& other) const {
  const SceneDistribution& a = distribution_;
  const SceneDistribution& b = other.distribution_;
  const auto free = [](const std::pair<double, double>& interval) {
    return interval.first < interval.second;
  };
  return free(a.radius) == free(b.radius) && free(a.aspect) == free(b.aspect) &&
         free(a.conductivity_ratio) == free(b.conductivity_ratio) && !a.centre && !b.centre;
}

Scene scene_of(const SceneDraw& drawn) {
  Scene scene;
  for (const ContactDraw& contact : drawn) scene.contacts.push_back(contact_of(contact));
  return scene;
}

double inset_area(const Sheet& sheet, double margin) {
  const Eigen::Vector2d sides = sheet.bounds().sizes();
  if (std::abs(sheet.area() - sides.prod()) < 1e-9 * sides.prod()) {
    return std::max(0.0, sides.x() - 2 * margin) * std::max(0.0, sides.y() - 2 * margin);
  }
  const double scale = 1 - margin / sheet.inner_radius();
  return sheet.area() * scale * scale;
}

}  // namespace ertbench
