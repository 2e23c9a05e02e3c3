#include "solvers/contacts/contact_bounds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "solvers/contacts/contact_moves.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr Index entries = EllipticContact::parameters;  // of a contact

/// How near to the sheet's border a contact may come, domain units of a sheet that is 2 across.
/// Much closer, and the points that a fit has time for do not resolve its mirror image.
constexpr double border_gap = 0.008;
/// Of a contact, over the deviation of its prior.
constexpr double longest_stretch = 3;
constexpr double smallest = 0.012;
constexpr double largest = 0.85;
constexpr double most_log_ratio = 4.5;
constexpr double any_log_ratio = 1e-3;
/// A contact at a corner breaks two constraints; one that grows finds them one after the other.
constexpr int most_rounds = 3;
/// Cosine of the angle between two normals of the border.
constexpr double same_side = 0.9;

/// How a point of a contact, given from its centre, moves with the contact's parameters.
Eigen::Matrix<double, 2, entries> moves_of(const EllipticContact& contact, const Vector2d& r) {
  Eigen::Matrix<double, 2, ContactMotion::count> motion;
  motion << 1, 0, r.x(), -r.y(), r.x(), r.y(), 0,  // x, in the order of ContactMotion
      0, 1, r.y(), r.x(), -r.y(), r.x(), 0;
  return motion * motion_of(contact);
}

}  // namespace

ContactBounds::ContactBounds(const Sheet& sheet, const ContactPrior& prior, bool ellipses)
    : sheet_(&sheet),
      ellipses_(ellipses),
      longest_(longest_stretch * prior.stretch_deviation),
      least_log_ratio_(prior.may_fall ? -most_log_ratio : any_log_ratio),
      largest_log_ratio_(prior.may_rise ? most_log_ratio : -any_log_ratio) {}

std::optional<ContactBounds::Nearest> ContactBounds::outside(const EllipticContact& contact) const {
  constexpr int probes = 16;
  constexpr double h = 1e-6;
  const Vector2d axes = contact.half_axes();
  // What no point of the contact can reach needs no looking at.
  if (sheet_->depth(contact.centre) >= axes.x() + border_gap) return std::nullopt;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(contact.angle()).toRotationMatrix();
  Nearest out;
  out.depth = std::numeric_limits<double>::infinity();
  const auto look_at = [&](const Vector2d& point) {
    const double depth = sheet_->depth(contact.centre + point);
    if (depth < out.depth) {
      out.depth = depth;
      out.point = point;
    }
  };
  for (int i = 0; i < probes; ++i) {
    const double t = 2 * std::numbers::pi * i / probes;
    look_at(turn * Vector2d(axes.x() * std::cos(t), axes.y() * std::sin(t)));
  }
  const auto normal = [&] {
    const Vector2d place = contact.centre + out.point;
    return Vector2d(sheet_->depth(place + Vector2d(h, 0)) - sheet_->depth(place - Vector2d(h, 0)),
                    sheet_->depth(place + Vector2d(0, h)) - sheet_->depth(place - Vector2d(0, h)))
        .normalized();
  };
  // The point of an ellipse that is farthest against n is -E n / sqrt(n'E n).
  const Vector2d n = normal();
  const Vector2d along = turn * (axes.cwiseAbs2().asDiagonal() * (turn.transpose() * n));
  look_at(-along / std::sqrt(n.dot(along)));
  if (out.depth >= border_gap) return std::nullopt;
  out.inwards = normal();
  return out;
}

void ContactBounds::keep_inside(EllipticContact& contact) const {
  const double stretch = contact.stretch.norm();
  if (stretch > longest_) contact.stretch *= longest_ / stretch;
  contact.log_size = std::clamp(contact.log_size, std::log(smallest * sheet_->inner_radius()),
                                std::log(largest * sheet_->inner_radius()));
  contact.log_ratio = std::clamp(contact.log_ratio, least_log_ratio_, largest_log_ratio_);
  constexpr int passes = 8;
  for (int pass = 0; pass < passes; ++pass) {
    const std::optional<Nearest> nearest = outside(contact);
    if (!nearest) return;
    contact.centre += (1.001 * border_gap - nearest->depth) * nearest->inwards;
    if (pass >= passes / 2) contact.log_size -= 0.1;  // it does not fit between two sides
  }
}

VectorXd ContactBounds::step(std::span<const EllipticContact> contacts,
                             const Eigen::LLT<Eigen::MatrixXd>& curvature,
                             const VectorXd& gradient) const {
  const VectorXd free = -curvature.solve(gradient);
  VectorXd out = free;
  Eigen::MatrixXd normals(free.size(), 0);
  VectorXd bounds;
  std::vector<std::pair<std::size_t, Vector2d>> whose;  // contact and border's normal
  for (int round = 0; round < most_rounds; ++round) {
    const double part = step_share(out);
    bool broken = false;
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Index at = entries * static_cast<Index>(k);
      const EllipticContact next =
          EllipticContact::from(contacts[k].vector() + part * out.segment<entries>(at));
      const std::optional<Nearest> nearest = outside(next);
      if (!nearest) continue;
      broken = true;
      EllipticContact::Vector normal =
          moves_of(next, nearest->point).transpose() * nearest->inwards;
      if (!ellipses_) normal.segment<2>(3).setZero();  // the stretch
      // The same side of the sheet again is the same constraint, linearised nearer by.
      const auto known = std::find_if(whose.begin(), whose.end(), [&](const auto& other) {
        return other.first == k && other.second.dot(nearest->inwards) > same_side;
      });
      const Index row = known - whose.begin();
      if (known == whose.end()) {
        whose.emplace_back(k, nearest->inwards);
        normals.conservativeResize(Eigen::NoChange, row + 1);
        bounds.conservativeResize(row + 1);
      }
      normals.col(row).setZero();
      normals.col(row).segment<entries>(at) = normal;
      bounds[row] = part * normal.dot(out.segment<entries>(at)) + border_gap - nearest->depth;
    }
    if (!broken) break;
    // The least of the model on the constraints: s + H^-1 A (A'H^-1 A)^-1 (b - A's).
    const Eigen::MatrixXd moves = curvature.solve(normals);
    const Eigen::MatrixXd between = normals.transpose() * moves;
    out = free + moves * between.completeOrthogonalDecomposition().solve(
                             bounds - normals.transpose() * free);
  }
  return out;
}

}  // namespace ertbench
