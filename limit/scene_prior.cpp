#include "limit/scene_prior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_model.h"
#include "forward/ellipses/ellipse_model.h"
#include "limit/scene_likelihood.h"

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

constexpr int metric_side = 24;  ///< places along one side
constexpr double probe_radius = 0.02;

constexpr double widest_step = 0.5;  ///< of a walk: position in domain units, and log size
/// The step that is still accepted may differ a hundredfold between contacts of one scene, so steps
/// are shortened by a random factor, down to exp(-this).
constexpr double log_narrowest = 4;

/// Probability of each move.
constexpr std::array<double, move_count> shares = {0.45, 0.2, 0.18, 0.12, 0.05, 0, 0, 0};
/// Standard deviation of each coordinate of the way from one part of a split contact to the other,
/// domain units.
constexpr double split_distance = 0.3;

std::size_t any_of(std::size_t count, RandomStream& random) {
  return static_cast<std::size_t>(random.integer(0, static_cast<int>(count) - 1));
}

/// `value` kept in [low, high] by reflection, which leaves steps symmetric.
double reflected(double value, double low, double high) {
  if (high <= low) return low;
  const double period = 2 * (high - low);
  double beyond = std::fmod(value - low, period);
  if (beyond < 0) beyond += period;
  return low + std::min(beyond, period - beyond);
}

double contrast(double ratio) { return (1 - ratio) / (1 + ratio); }

/// The size of a contact of the form of `other` that is as strong as one of the form of `contact`
/// and the size 1.
double size_of_equal(ContactDraw contact, ContactDraw other) {
  contact.size = 1;
  other.size = 1;
  return std::sqrt(strength_of(contact) / strength_of(other));
}

double narrowed(double scale, RandomStream& random) {
  return scale * std::exp(-log_narrowest * random.uniform());
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
  if (std::ranges::find(d.shapes, contact.shape) == d.shapes.end()) return never;
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

double area_of(const ContactDraw& contact) { return nearest_ellipse(contact_of(contact)).area(); }

double strength_of(const ContactDraw& contact) {
  const double f = contact.conductivity_ratio;
  return area_of(contact) * 2 * (1 - f) / (1 + f);
}

PlaceMetric::PlaceMetric(const Eigen::Matrix3d& precision)
    : box_(Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, 1)), precision_{precision} {}

PlaceMetric::PlaceMetric(const Sensor& sensor, double channel_noise)
    : box_(sensor.sheet->bounds()) {
  const BorderModel model(sensor);
  const PixelGrid places = sensor.sheet->pixels(metric_side);
  columns_ = places.columns();
  rows_ = places.rows();
  ContactDraw probe;
  probe.size = probe_radius;
  probe.conductivity_ratio = 0.5;
  const double strength = strength_of(probe);
  const auto change_at = [&](const Eigen::Vector2d& centre) -> Eigen::VectorXd {
    probe.centre = centre;
    // At a corner of the bounds there may be no sheet.
    if (sensor.sheet->depth(centre) < probe_radius) {
      return Eigen::VectorXd::Zero(sensor.channels());
    }
    return model.solve_at(scene_of({probe}), 1).change / (strength * channel_noise);
  };
  const double step = places.pixel().x() / 4;
  for (int p = 0; p < places.count(); ++p) {
    const Eigen::Vector2d centre = places.centre(p);
    const auto slope = [&](const Eigen::Vector2d& by) -> Eigen::VectorXd {
      return (change_at(centre + by) - change_at(centre - by)) / (2 * step);
    };
    Eigen::MatrixX3d jacobian(sensor.channels(), 3);
    jacobian.col(0) = slope({step, 0});
    jacobian.col(1) = slope({0, step});
    jacobian.col(2) = change_at(centre);
    precision_.emplace_back(jacobian.transpose() * jacobian);
  }
}

Eigen::Matrix3d PlaceMetric::information(const ContactDraw& contact) const {
  const Eigen::Vector2d place = (contact.centre - box_.min()).cwiseQuotient(box_.sizes());
  const int column = std::clamp(static_cast<int>(place.x() * columns_), 0, columns_ - 1);
  const int row = std::clamp(static_cast<int>(place.y() * rows_), 0, rows_ - 1);
  const double strength = strength_of(contact);
  // The strength grows with the square of the size.
  const Eigen::Vector3d scale(strength, strength, 2 * strength);
  return scale.asDiagonal() * precision_[static_cast<std::size_t>(row * columns_ + column)] *
         scale.asDiagonal();
}

Move SceneMoves::choose(RandomStream& random) const {
  double left = random.uniform();
  for (int m = 0; m < move_count; ++m) {
    left -= shares[static_cast<std::size_t>(m)];
    if (left < 0) return static_cast<Move>(m);
  }
  return Move::walk;
}

std::optional<Proposal> SceneMoves::propose(Move move, const SceneDraw& scene, double scale,
                                            double heat, RandomStream& random) const {
  if (move == Move::number) return number(scene, random);
  if (scene.empty()) return std::nullopt;
  switch (move) {
    case Move::walk:
      return walk(scene, scale, heat, random);
    case Move::exchange:
      return exchange(scene, scale, random);
    case Move::form:
      return form(scene, scale, random);
    case Move::reshape:
      return reshape(scene, random);
    case Move::split:
      return split(scene, random);
    default:
      return redraw(scene, random);
  }
}

std::optional<Proposal> SceneMoves::walk(const SceneDraw& scene, double scale, double heat,
                                         RandomStream& random) const {
  const bool sizes = prior_.size_is_free();
  const Eigen::Index free = sizes ? 3 : 2;
  const auto factor = [&](const ContactDraw& contact) {
    Eigen::Matrix3d precision = heat * metric_.information(contact);
    precision.diagonal().array() += 1 / (widest_step * widest_step);
    return Eigen::LLT<Eigen::MatrixXd>(precision.topLeftCorner(free, free) / (scale * scale));
  };
  const auto log_density = [](const Eigen::LLT<Eigen::MatrixXd>& llt, const Eigen::VectorXd& step) {
    const Eigen::VectorXd white = llt.matrixU() * step;
    return sum_of_logs(llt.matrixLLT().diagonal().array()) - white.squaredNorm() / 2;
  };
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const Eigen::LLT<Eigen::MatrixXd> forth = factor(contact);
  Eigen::VectorXd step(free);
  for (double& value : step) value = random.normal();
  step = forth.matrixU().solve(step).eval();
  contact.centre += step.head<2>();
  if (sizes) contact.size *= std::exp(step[2]);
  if (!std::isfinite(prior_.log_density(contact))) return std::nullopt;
  const Eigen::LLT<Eigen::MatrixXd> back = factor(contact);
  // The step is in the logarithm of the size, while the prior has a density in the size.
  proposal.log_ratio = log_density(back, -step) - log_density(forth, step) + (sizes ? step[2] : 0);
  return proposal;
}

std::optional<Proposal> SceneMoves::exchange(const SceneDraw& scene, double scale,
                                             RandomStream& random) const {
  if (!prior_.ratio_is_free()) return std::nullopt;
  const auto [low, high] = prior_.distribution().conductivity_ratio;
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const double before = contact.conductivity_ratio;
  const double width = narrowed(scale, random) * 0.5 * (high - low);
  contact.conductivity_ratio = reflected(before + width * random.normal(), low, high);
  if (prior_.size_is_free()) {
    const double growth = contrast(before) / contrast(contact.conductivity_ratio);
    if (!(growth > 0) || !std::isfinite(growth)) return std::nullopt;
    contact.size *= std::sqrt(growth);
    proposal.log_ratio = std::log(growth) / 2;
  }
  return proposal;
}

double SceneMoves::keep_ellipse(const EllipticContact& before, ContactDraw& contact) const {
  double log_growth = 0;
  if (prior_.size_is_free()) {
    const double growth = std::sqrt(before.area() / area_of(contact));
    contact.size *= growth;
    log_growth = std::log(growth);
  }
  if (!prior_.distribution().centre) {
    contact.centre += before.centre - nearest_ellipse(contact_of(contact)).centre;
  }
  return log_growth;
}

std::optional<Proposal> SceneMoves::form(const SceneDraw& scene, double scale,
                                         RandomStream& random) const {
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const EllipticContact before = nearest_ellipse(contact_of(contact));
  const double width = narrowed(scale, random);
  const auto [low, high] = prior_.distribution().aspect;
  if (random.uniform() < 0.5 || contact.corners.empty()) {
    contact.aspect =
        reflected(contact.aspect + width * 0.5 * (high - low) * random.normal(), low, high);
    contact.angle = std::fmod(contact.angle + width * random.normal(), std::numbers::pi);
    if (contact.angle < 0) contact.angle += std::numbers::pi;
  } else {
    ContactDraw::Corner& corner = contact.corners[any_of(contact.corners.size(), random)];
    corner.turn =
        reflected(corner.turn + width * corner_turn * random.normal(), -corner_turn, corner_turn);
    corner.reach = reflected(corner.reach + width * 0.5 * random.normal(), 0, 1);
  }
  proposal.log_ratio = keep_ellipse(before, contact);
  return proposal;
}

std::optional<Proposal> SceneMoves::reshape(const SceneDraw& scene, RandomStream& random) const {
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const ContactDraw before = contact;
  const ContactDraw other = prior_.draw_contact(random);
  contact.shape = other.shape;
  if (random.uniform() < 0.5) {
    // All shapes but polygons share the meaning of angle and aspect.
    if (!before.corners.empty() || !other.corners.empty()) return std::nullopt;
  } else {
    contact.aspect = other.aspect;
    contact.angle = other.angle;
    contact.corners = other.corners;
    proposal.log_ratio = prior_.log_form_density(before) - prior_.log_form_density(contact);
  }
  proposal.log_ratio += keep_ellipse(nearest_ellipse(contact_of(before)), contact);
  return proposal;
}

std::optional<Proposal> SceneMoves::redraw(const SceneDraw& scene, RandomStream& random) const {
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const double log_before = prior_.log_density(contact);
  contact = prior_.draw_contact(random);
  proposal.log_ratio = log_before - prior_.log_density(contact);
  return proposal;
}

std::optional<Proposal> SceneMoves::number(const SceneDraw& scene, RandomStream& random) const {
  // A new contact takes any place in the list, and any contact may go, so that the places cancel.
  Proposal proposal{scene, 0};
  SceneDraw& contacts = proposal.scene;
  if (random.uniform() < 0.5) {
    const ContactDraw added = prior_.draw_contact(random);
    const std::size_t at = any_of(contacts.size() + 1, random);
    contacts.insert(contacts.begin() + static_cast<std::ptrdiff_t>(at), added);
    proposal.log_ratio = -prior_.log_density(added);
  } else {
    if (contacts.empty()) return std::nullopt;
    const auto gone =
        contacts.begin() + static_cast<std::ptrdiff_t>(any_of(contacts.size(), random));
    proposal.log_ratio = prior_.log_density(*gone);
    contacts.erase(gone);
  }
  return proposal;
}

std::optional<Proposal> SceneMoves::split(const SceneDraw& scene, RandomStream& random) const {
  const bool splits = random.uniform() < 0.5;
  if (!splits && scene.size() < 2) return std::nullopt;
  Proposal proposal{scene, 0};
  SceneDraw& contacts = proposal.scene;
  // The second part takes any place in the list, and any two in either order may merge, so that the
  // places cancel.
  const std::size_t at = any_of(contacts.size() + (splits ? 1 : 0), random);
  ContactDraw part = splits ? prior_.draw_contact(random) : contacts[at];
  if (!splits) contacts.erase(contacts.begin() + static_cast<std::ptrdiff_t>(at));
  ContactDraw& contact = contacts[any_of(contacts.size(), random)];
  const bool sizes = prior_.size_is_free();
  const double growth = sizes ? size_of_equal(contact, part) : 1;
  if (!(growth > 0) || !std::isfinite(growth)) return std::nullopt;
  // `share` of the strength is the first part's; without free sizes the parts are alike.
  double share = 0.5;
  double whole = contact.size;
  Eigen::Vector2d way;
  if (splits) {
    if (sizes) share = random.uniform();
    way = {split_distance * random.normal(), split_distance * random.normal()};
    part.centre = contact.centre + share * way;
    contact.centre -= (1 - share) * way;
    if (sizes) part.size = growth * whole * std::sqrt(1 - share);
    if (sizes) contact.size = whole * std::sqrt(share);
    contacts.insert(contacts.begin() + static_cast<std::ptrdiff_t>(at), part);
  } else {
    if (sizes) {
      whole = std::hypot(contact.size, part.size / growth);
      share = std::pow(contact.size / whole, 2);
      contact.size = whole;
    }
    way = part.centre - contact.centre;
    contact.centre += (1 - share) * way;
  }
  constexpr double variance = split_distance * split_distance;
  double log_split = way.squaredNorm() / (2 * variance) +
                     std::log(2 * std::numbers::pi * variance) - prior_.log_form_density(part);
  // The derivative of the two sizes by the whole one and the share.
  if (sizes) log_split += std::log(growth * whole / (2 * std::sqrt(share * (1 - share))));
  proposal.log_ratio = splits ? log_split : -log_split;
  return proposal;
}

}  // namespace ertbench
