#include "bench/limit/scene_moves.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/limit/elementwise.h"
#include "forward/ellipses/nearest_ellipse.h"

namespace ertbench {
namespace {

constexpr double widest_step = 0.5;  ///< of a walk: of places in domain units, and of log size
/// Contacts of one scene may differ by a hundred in how far a step may go that is still taken:
/// steps are shortened by a random factor, down to exp(-this).
constexpr double log_narrowest = 4;

/// How often each move is tried, adding up to 1.
constexpr std::array<double, move_count> shares = {0.45, 0.2, 0.18, 0.12, 0.05, 0};

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

double narrowed(double scale, RandomStream& random) {
  return scale * std::exp(-log_narrowest * random.uniform());
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
    // Angle and aspect mean the same to all shapes but polygons.
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

}  // namespace ertbench
