#include "solvers/contacts/contact_fit.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr Index entries = EllipticContact::parameters;  // of a contact

/// Least distance of a contact from the sheet's border, domain units. With the points that a fit
/// can afford, the mirror image of a nearer contact is not resolved.
constexpr double border_gap = 0.008;
/// Largest stretch of a contact, over the deviation of its prior.
constexpr double longest_stretch = 3;
constexpr double smallest = 0.012;
constexpr double largest = 0.85;
constexpr double most_log_ratio = 4.5;
constexpr double any_log_ratio = 1e-3;
/// A contact in a corner violates two constraints; a growing one meets them one after the other.
constexpr int most_rounds = 3;
/// Cosine of the angle between two normals of the border.
constexpr double same_side = 0.9;

/// [2, entries] derivatives of a point `r` from the contact's centre with respect to the contact's
/// parameters.
Eigen::Matrix<double, 2, entries> moves_of(const EllipticContact& contact, const Vector2d& r) {
  Eigen::Matrix<double, 2, ContactMotion::count> motion;
  motion << 1, 0, r.x(), -r.y(), r.x(), r.y(), 0,  // x, in the order of ContactMotion
      0, 1, r.y(), r.x(), -r.y(), r.x(), 0;
  return motion * motion_of(contact);
}

/// A fit has converged if a step gains less than this of the log posterior.
constexpr double least_gain = 0.05;
/// Points of the model while starts are tried.
constexpr EllipseModel::Options coarse_points = {1.0, 24};
/// A trial stops if `steps_ahead` steps like the last one would not reach its required evidence,
/// but not within its first `least_steps`. After `patient_steps` it also stops if it is `far`
/// behind.
constexpr double steps_ahead = 4;
constexpr int least_steps = 2;
constexpr int patient_steps = 6;
constexpr double far = 40;
/// Number of points at which the quadratic part of the cost of a solve equals the linear part.
constexpr int square_points = 70;

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
  // The border is out of reach of every point of the contact.
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
    if (pass >= passes / 2) contact.log_size -= 0.1;  // too large to fit between two sides
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
      // A second violation at the same side replaces the first, linearised closer to it.
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
    // Minimum of the model under the constraints: s + H^-1 A (A'H^-1 A)^-1 (b - A's).
    const Eigen::MatrixXd moves = curvature.solve(normals);
    const Eigen::MatrixXd between = normals.transpose() * moves;
    out = free + moves * between.completeOrthogonalDecomposition().solve(
                             bounds - normals.transpose() * free);
  }
  return out;
}

struct ContactFit::Point {
  double objective = std::numeric_limits<double>::infinity();
  double misfit = 0;
  VectorXd gradient;
  VectorXd prior;  ///< its curvature's diagonal
  MatrixXd curvature;
};

ContactFit::ContactFit(const Sensor& sensor, const ContactPrior& prior, const MatrixXd& whitening,
                       const Options& options)
    : model_(sensor),
      coarse_(sensor, coarse_points),
      prior_(prior),
      options_(options),
      bounds_(*model_.sensor().sheet, prior, options.ellipses),
      whitening_(whitening),
      atoms_(model_, whitening) {
  const double first = whitening(0, 0);
  if (whitening.isApprox(first * MatrixXd::Identity(whitening.rows(), whitening.cols()), 1e-12)) {
    uniform_noise_ = 1 / first;
  }
}

void ContactFit::set_kept(const VectorXd& kept, Workspace& workspace) const {
  workspace.kept = kept;
  workspace.ignored.resize(0, 0);
  if (uniform_noise_ > 0 || kept.size() == 0 || whitening_.isDiagonal(1e-12)) return;
  std::vector<Index> ignored;
  for (Index p = 0; p < kept.size(); ++p) {
    // Half the standard deviation: a quarter of the weight.
    if (kept[p] < 0.5) ignored.push_back(p);
    workspace.kept[p] = kept[p] < 0.5 ? 0 : 1;
  }
  if (ignored.empty()) return;
  const MatrixXd reached = whitening_(Eigen::all, ignored);
  workspace.ignored =
      reached.householderQr().householderQ() * MatrixXd::Identity(reached.rows(), reached.cols());
}

void ContactFit::set_weights(Workspace& workspace) const {
  workspace.weights.setConstant(model_.pairs(), workspace.scale);
  weigh_pairs(workspace);
}

void ContactFit::weigh_pairs(Workspace& workspace) {
  if (workspace.kept.size() == 0 || workspace.ignored.size() > 0) return;
  workspace.weights.array() *= workspace.kept.array();
}

void ContactFit::whitened_residual(const VectorXd& changes, Workspace& workspace) const {
  workspace.change.resize(model_.pairs());
  model_in_use(workspace).evaluate(workspace.model, workspace.change);
  if (uniform_noise_ > 0) {
    workspace.whitened = (changes - workspace.change) / uniform_noise_;
  } else {
    workspace.residual = changes - workspace.change;
    workspace.whitened.noalias() = whitening_ * workspace.residual;
    project(workspace, workspace.whitened);
  }
}

void ContactFit::measure(const VectorXd& changes, std::span<const EllipticContact> contacts,
                         Workspace& workspace, Point& point) const {
  ++workspace.iterations;
  const int points = workspace.model.points();
  workspace.work += points + points * points / square_points;
  whitened_residual(changes, workspace);
  workspace.whitened.array() *= workspace.weights.array();
  point.misfit = workspace.whitened.squaredNorm();
  point.objective = point.misfit / 2;
  point.gradient.setZero(entries * static_cast<Index>(contacts.size()));
  point.prior.setZero(point.gradient.size());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Index at = entries * static_cast<Index>(k);
    point.objective +=
        prior_.add_to(contacts[k], options_.prior_weight, point.gradient.segment<entries>(at),
                      point.prior.segment<entries>(at));
  }
}

void ContactFit::linearise(Workspace& workspace, Point& point) const {
  MatrixXd& columns = workspace.columns;
  workspace.derivatives.resize(model_.pairs(), point.gradient.size());
  model_in_use(workspace).derivatives(workspace.model, workspace.derivatives);
  if (uniform_noise_ > 0) {
    columns = (workspace.weights / uniform_noise_).asDiagonal() * workspace.derivatives;
  } else {
    columns.noalias() = whitening_ * workspace.derivatives;
    project(workspace, columns);
    columns.array().colwise() *= workspace.weights.array();
  }
  if (!options_.ellipses) {
    for (Index k = 0; k < columns.cols(); k += entries) columns.middleCols<2>(k + 3).setZero();
  }
  point.gradient.noalias() -= columns.transpose() * workspace.whitened;
  point.curvature.noalias() = columns.transpose() * columns;
  point.curvature.diagonal() += point.prior;
}

double ContactFit::log_evidence(double objective, const MatrixXd& precision,
                                std::size_t contacts) const {
  const auto number = static_cast<double>(contacts);
  // Only the prior depends on a disc's stretch; its constant and its volume cancel.
  double out = -objective + std::lgamma(number + 1) +
               number * prior_.log_constant(options_.prior_weight, model_.sensor().sheet->area());
  if (contacts == 0) return out;
  const Eigen::LLT<MatrixXd> factor(precision);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  for (Index i = 0; i < precision.rows(); ++i) {
    out += std::log(2 * std::numbers::pi) / 2 - std::log(factor.matrixLLT()(i, i));
  }
  return out;
}

bool ContactFit::step_to(std::span<const EllipticContact> contacts, const VectorXd& step,
                         Workspace& workspace, std::vector<EllipticContact>& next) const {
  constexpr int most_halvings = 3;
  for (int halvings = 0; halvings <= most_halvings; ++halvings) {
    next = moved(contacts, std::ldexp(1.0, -halvings) * step);
    for (EllipticContact& contact : next) bounds_.keep_inside(contact);
    if (model_in_use(workspace).place(next, workspace.model)) return true;
  }
  return false;
}

void ContactFit::optimise(const VectorXd& changes, std::vector<EllipticContact> contacts,
                          const Effort& effort, Workspace& workspace, Result& result) const {
  for (EllipticContact& contact : contacts) bounds_.keep_inside(contact);
  // A new contact that overlaps others starts smaller.
  bool placed = model_in_use(workspace).place(contacts, workspace.model);
  for (int shrink = 0; shrink < 3 && !placed; ++shrink) {
    contacts.back().log_size -= 0.4;
    placed = model_in_use(workspace).place(contacts, workspace.model);
  }
  result = {};
  result.log_evidence = -std::numeric_limits<double>::infinity();
  if (!placed) return;
  Point point;
  Point trial;
  result.converged = false;
  measure(changes, contacts, workspace, point);
  if (!std::isfinite(point.objective)) return;
  linearise(workspace, point);
  const double pairs = pairs_in_use(workspace);
  double damping = 0.01;
  double gained = 0;
  std::vector<EllipticContact> next;
  MatrixXd damped;
  for (int i = 0; i < effort.iterations && !result.converged; ++i) {
    if (i > 0 && workspace.work > most_work) break;
    const double enough = std::max(least_gain, effort.looseness * (point.misfit - pairs) / 2);
    damped = point.curvature;
    damped.diagonal() +=
        damping * point.curvature.diagonal() + VectorXd::Constant(damped.rows(), 1e-9);
    const VectorXd step = bounds_.step(contacts, damped.llt(), point.gradient);
    const double promise = -point.gradient.dot(step) - step.dot(damped * step) / 2;
    if (i >= least_steps) {
      const double evidence = log_evidence(point.objective, point.curvature, contacts.size());
      const double ahead = i >= patient_steps ? far : std::numeric_limits<double>::infinity();
      if (evidence + std::min(ahead, steps_ahead * std::max(promise, gained)) <
          effort.least_evidence) {
        break;
      }
    }
    bool better = step_to(contacts, step, workspace, next);
    if (better) {
      measure(changes, next, workspace, trial);
      better = trial.objective < point.objective;
    }
    if (better) {
      linearise(workspace, trial);
      gained = point.objective - trial.objective;
      result.converged = gained < enough;
      std::swap(point, trial);
      std::swap(contacts, next);
      const double kept = gained / promise;  // gain over that of the linear model
      damping = std::max(1e-6, damping * (kept > 0.75 ? 0.2 : kept > 0.25 ? 0.5 : 2));
    } else {
      // Gain of the step under the linear model.
      result.converged = promise < enough || damping > 1e4;
      damping = std::max(1e-3, damping * 8);
    }
  }
  result.settled = result.converged && effort.looseness * (point.misfit - pairs) / 2 <= least_gain;
  result.contacts = std::move(contacts);
  result.discs = !options_.ellipses;
  result.misfit = point.misfit;
  result.log_evidence = log_evidence(point.objective, point.curvature, result.contacts.size());
  result.precision = std::move(point.curvature);
}

}  // namespace ertbench
