#include "bench/limit/scene_moves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/limit/elementwise.h"

namespace ertbench {
namespace {

constexpr double widest_step = 0.5;     ///< of a walk: of places in domain units, and of log size
constexpr double split_distance = 0.3;  ///< standard deviation between the parts, domain units

/// How often each move is tried, adding up to 1.
constexpr std::array<double, move_count> shares = {0.45, 0.17, 0.14, 0.08, 0.08, 0.08, 0};

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

/// The cosine-like factor of size against conductivity in the strength.
double contrast(double ratio) { return (1 - ratio) / (1 + ratio); }

double log_normal(const Eigen::Vector2d& x, double deviation) {
  return -x.squaredNorm() / (2 * deviation * deviation) -
         2 * std::log(deviation * std::sqrt(2 * std::numbers::pi));
}

}  // namespace

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
  const bool grows = random.uniform() < 0.5;
  if (move == Move::birth) return grows ? birth(scene, random) : death(scene, random);
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
    default:
      return grows ? split(scene, random) : merge(scene, random);
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
  // The step is one of the logarithm of the size, whose density the prior has.
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
  contact.conductivity_ratio =
      reflected(before + scale * 0.5 * (high - low) * random.normal(), low, high);
  if (prior_.size_is_free()) {
    const double growth = contrast(before) / contrast(contact.conductivity_ratio);
    if (!(growth > 0) || !std::isfinite(growth)) return std::nullopt;
    contact.size *= std::sqrt(growth);
    proposal.log_ratio = std::log(growth) / 2;
  }
  return proposal;
}

double SceneMoves::keep_area(double area, ContactDraw& contact) const {
  if (!prior_.size_is_free()) return 0;
  const double growth = std::sqrt(area / area_of(contact));
  contact.size *= growth;
  return std::log(growth);
}

std::optional<Proposal> SceneMoves::form(const SceneDraw& scene, double scale,
                                         RandomStream& random) const {
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const double area = area_of(contact);
  const auto [low, high] = prior_.distribution().aspect;
  if (random.uniform() < 0.5 || contact.corners.empty()) {
    contact.aspect =
        reflected(contact.aspect + scale * 0.5 * (high - low) * random.normal(), low, high);
    contact.angle = std::fmod(contact.angle + scale * random.normal(), std::numbers::pi);
    if (contact.angle < 0) contact.angle += std::numbers::pi;
  } else {
    ContactDraw::Corner& corner = contact.corners[any_of(contact.corners.size(), random)];
    corner.turn =
        reflected(corner.turn + scale * corner_turn * random.normal(), -corner_turn, corner_turn);
    corner.reach = reflected(corner.reach + scale * 0.5 * random.normal(), 0, 1);
  }
  proposal.log_ratio = keep_area(area, contact);
  return proposal;
}

std::optional<Proposal> SceneMoves::reshape(const SceneDraw& scene, RandomStream& random) const {
  Proposal proposal{scene, 0};
  ContactDraw& contact = proposal.scene[any_of(scene.size(), random)];
  const ContactDraw before = contact;
  const ContactDraw other = prior_.draw_contact(random);
  contact.shape = other.shape;
  contact.aspect = other.aspect;
  contact.angle = other.angle;
  contact.corners = other.corners;
  const double log_forms = prior_.log_form_density(before) - prior_.log_form_density(contact);
  proposal.log_ratio = keep_area(area_of(before), contact) + log_forms;
  return proposal;
}

std::optional<Proposal> SceneMoves::birth(const SceneDraw& scene, RandomStream& random) const {
  if (!std::isfinite(prior_.log_count(scene.size() + 1))) return std::nullopt;
  Proposal proposal{scene, 0};
  const ContactDraw born = prior_.draw_contact(random);
  const auto place = static_cast<std::ptrdiff_t>(any_of(scene.size() + 1, random));
  proposal.scene.insert(proposal.scene.begin() + place, born);
  proposal.log_ratio = -prior_.log_density(born);
  return proposal;
}

std::optional<Proposal> SceneMoves::death(const SceneDraw& scene, RandomStream& random) const {
  if (scene.empty() || !std::isfinite(prior_.log_count(scene.size() - 1))) return std::nullopt;
  Proposal proposal{scene, 0};
  const auto dead = static_cast<std::ptrdiff_t>(any_of(scene.size(), random));
  proposal.log_ratio = prior_.log_density(scene[static_cast<std::size_t>(dead)]);
  proposal.scene.erase(proposal.scene.begin() + dead);
  return proposal;
}

// With w the share of the first part in the strength and d the way from the second to the first,
// (place, size, w, d) and the places and sizes of the two parts are coordinates of the same six
// quantities: the places' Jacobian is 1, and that of the sizes r sqrt(w), r sqrt(k (1 - w)) by
// (r, w) is r sqrt(k / (w (1 - w))) / 2, k the strength of the first form over that of the second
// at equal sizes.

std::optional<Proposal> SceneMoves::split(const SceneDraw& scene, RandomStream& random) const {
  if (!prior_.size_is_free() || !std::isfinite(prior_.log_count(scene.size() + 1))) {
    return std::nullopt;
  }
  Proposal proposal{scene, 0};
  const std::size_t chosen = any_of(scene.size(), random);
  ContactDraw& first = proposal.scene[chosen];
  const ContactDraw whole = first;
  ContactDraw second = prior_.draw_contact(random);
  const double log_form = prior_.log_form_density(second);
  const double share = random.uniform();
  Eigen::Vector2d apart(random.normal(), random.normal());
  apart *= split_distance;
  second.size = whole.size;
  const double k = strength_of(whole) / strength_of(second);
  if (!(k > 0) || !std::isfinite(k) || share <= 0) return std::nullopt;
  first.centre = whole.centre + (1 - share) * apart;
  first.size = whole.size * std::sqrt(share);
  second.centre = whole.centre - share * apart;
  second.size = whole.size * std::sqrt(k * (1 - share));
  proposal.log_ratio = -log_form - log_normal(apart, split_distance) + std::log(whole.size / 2) +
                       std::log(k / (share * (1 - share))) / 2;
  const auto place = static_cast<std::ptrdiff_t>(any_of(scene.size() + 1, random));
  proposal.scene.insert(proposal.scene.begin() + place, second);
  return proposal;
}

std::optional<Proposal> SceneMoves::merge(const SceneDraw& scene, RandomStream& random) const {
  if (!prior_.size_is_free() || scene.size() < 2 ||
      !std::isfinite(prior_.log_count(scene.size() - 1))) {
    return std::nullopt;
  }
  Proposal proposal{scene, 0};
  const std::size_t kept = any_of(scene.size(), random);
  std::size_t gone = any_of(scene.size() - 1, random);
  if (gone >= kept) ++gone;
  const ContactDraw& first = scene[kept];
  const ContactDraw& second = scene[gone];
  const double strength = strength_of(first);
  const double more = strength_of(second) / strength;
  if (!(more > 0) || !std::isfinite(more)) return std::nullopt;
  ContactDraw& whole = proposal.scene[kept];
  const double share = 1 / (1 + more);
  const Eigen::Vector2d apart = first.centre - second.centre;
  whole.centre = share * first.centre + (1 - share) * second.centre;
  whole.size = first.size * std::sqrt(1 + more);
  const double sizes = second.size / first.size;
  const double k = sizes * sizes / more;  // strengths at equal sizes
  proposal.log_ratio = prior_.log_form_density(second) + log_normal(apart, split_distance) -
                       std::log(whole.size / 2) - std::log(k / (share * (1 - share))) / 2;
  proposal.scene.erase(proposal.scene.begin() + static_cast<std::ptrdiff_t>(gone));
  return proposal;
}

}  // namespace ertbench
