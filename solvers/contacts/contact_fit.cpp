#include "solvers/contacts/contact_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/contacts/contact_moves.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index numbers = EllipticContact::parameters;  // of a contact

/// A fit is done where a step gains less of the logarithm of the posterior.
constexpr double least_gain = 0.02;
/// A further contact is tried where the best atom promises more of it: no contact's six numbers
/// cost less.
constexpr double promising = 6;
/// Steps from each of several starts before the best of them goes on.
constexpr int first_steps = 3;
constexpr int most_starts = 3;
/// A frame is done where its iterations have taken so many points in all: frames that no few
/// ellipses explain would go on, with contacts ever closer to each other.
constexpr int most_work = 2200;
/// While the first contact's whereabouts are not known, a channel counts with this part of its
/// voltage as noise: large voltages next to electrodes change too fast for a start to be near.
constexpr double soft = 0.4;
/// Starts that promise so much less than the best are not tried.
constexpr double hopeless = 12;
/// A number of contacts whose evidence is so much less has no part in the image.
constexpr double negligible = 6;
/// How near to the sheet's border a contact may come, domain units of a sheet that is 2 across.
constexpr double border_gap = 0.006;
/// Of a contact, over the deviation of its prior.
constexpr double longest_stretch = 3;
constexpr double smallest = 0.012;
constexpr double largest = 0.85;
constexpr double largest_log_ratio = 4.5;
constexpr double least_log_ratio = 1e-3;

}  // namespace

struct ContactFit::Point {
  double objective = std::numeric_limits<double>::infinity();
  double misfit = 0;
  VectorXd gradient;
  MatrixXd curvature;
};

ContactFit::ContactFit(const Sensor& sensor, const ContactPrior& prior, const MatrixXd& whitening,
                       const Options& options)
    : model_(sensor),
      prior_(prior),
      options_(options),
      whitening_(whitening),
      atoms_(model_, whitening) {
  const double first = whitening(0, 0);
  if (whitening.isApprox(first * MatrixXd::Identity(whitening.rows(), whitening.cols()), 1e-12)) {
    uniform_noise_ = 1 / first;
  }
}

void ContactFit::keep_inside(EllipticContact& contact) const {
  const Sheet& sheet = *model_.sensor().sheet;
  const double stretch = contact.stretch.norm();
  const double longest = longest_stretch * prior_.stretch_deviation;
  if (stretch > longest) contact.stretch *= longest / stretch;
  contact.log_size = std::clamp(contact.log_size, std::log(smallest * sheet.inner_radius()),
                                std::log(largest * sheet.inner_radius()));
  contact.log_ratio =
      std::clamp(contact.log_ratio, prior_.may_fall ? -largest_log_ratio : least_log_ratio,
                 prior_.may_rise ? largest_log_ratio : -least_log_ratio);
  constexpr int probes = 16;
  constexpr int passes = 8;
  constexpr double h = 1e-6;
  for (int pass = 0; pass < passes; ++pass) {
    const Eigen::Vector2d axes = contact.half_axes();
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(contact.angle()).toRotationMatrix();
    double least = border_gap;
    Eigen::Vector2d where;
    for (int i = 0; i < probes; ++i) {
      const double t = 2 * std::numbers::pi * i / probes;
      const Eigen::Vector2d place =
          contact.centre + turn * Eigen::Vector2d(axes.x() * std::cos(t), axes.y() * std::sin(t));
      const double depth = sheet.depth(place);
      if (depth < least) {
        least = depth;
        where = place;
      }
    }
    if (least >= border_gap) return;
    const Eigen::Vector2d inwards(
        sheet.depth(where + Eigen::Vector2d(h, 0)) - sheet.depth(where - Eigen::Vector2d(h, 0)),
        sheet.depth(where + Eigen::Vector2d(0, h)) - sheet.depth(where - Eigen::Vector2d(0, h)));
    contact.centre += (1.001 * border_gap - least) / inwards.norm() * inwards;
    if (pass >= passes / 2) contact.log_size -= 0.1;  // it does not fit between two sides
  }
}

void ContactFit::set_weights(Workspace& workspace) const {
  workspace.weights.setConstant(model_.pairs(), workspace.scale);
  if (workspace.kept.size() > 0) workspace.weights.array() *= workspace.kept.array();
}

bool ContactFit::derivatives_of(std::span<const EllipticContact> contacts,
                                Workspace& workspace) const {
  workspace.change.resize(model_.pairs());
  workspace.derivatives.resize(model_.pairs(), numbers * static_cast<Index>(contacts.size()));
  return model_.evaluate(contacts, workspace.model, workspace.change, workspace.derivatives);
}

bool ContactFit::linearise(const VectorXd& changes, std::span<const EllipticContact> contacts,
                           Workspace& workspace, Point& point) const {
  ++workspace.iterations;
  if (!derivatives_of(contacts, workspace)) return false;
  workspace.work += workspace.model.points();
  MatrixXd& columns = workspace.columns;
  workspace.residual = changes - workspace.change;
  if (uniform_noise_ > 0) {
    workspace.whitened = workspace.residual / uniform_noise_;
    columns = workspace.derivatives / uniform_noise_;
  } else {
    workspace.whitened.noalias() = whitening_ * workspace.residual;
    columns.noalias() = whitening_ * workspace.derivatives;
  }
  workspace.whitened.array() *= workspace.weights.array();
  columns.array().colwise() *= workspace.weights.array();
  if (!options_.ellipses) {
    for (Index k = 0; k < columns.cols(); k += numbers) columns.middleCols<2>(k + 3).setZero();
  }
  point.misfit = workspace.whitened.squaredNorm();
  point.objective = point.misfit / 2;
  point.gradient.noalias() = -columns.transpose() * workspace.whitened;
  point.curvature.noalias() = columns.transpose() * columns;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const Index at = numbers * static_cast<Index>(k);
    EllipticContact::Vector diagonal = EllipticContact::Vector::Zero();
    point.objective += prior_.add_to(contacts[k], options_.prior_weight,
                                     point.gradient.segment<numbers>(at), diagonal);
    point.curvature.diagonal().segment<numbers>(at) += diagonal;
  }
  return std::isfinite(point.objective);
}

double ContactFit::log_evidence(double objective, const MatrixXd& precision,
                                std::size_t contacts) const {
  const auto number = static_cast<double>(contacts);
  // A disc's stretch has its prior alone, whose constant and volume cancel.
  double out =
      -objective + std::lgamma(number + 1) +
      number * prior_.log_constant(options_.prior_weight, model_.sensor().sheet->area(), true);
  if (contacts == 0) return out;
  const Eigen::LLT<MatrixXd> factor(precision);
  if (factor.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  for (Index i = 0; i < precision.rows(); ++i) {
    out += std::log(2 * std::numbers::pi) / 2 - std::log(factor.matrixLLT()(i, i));
  }
  return out;
}

std::vector<EllipticContact> ContactFit::stepped(std::span<const EllipticContact> contacts,
                                                 const VectorXd& step, Workspace& workspace) const {
  double part = 1;
  while (true) {
    std::vector<EllipticContact> next = moved(contacts, part * step);
    for (EllipticContact& contact : next) keep_inside(contact);
    part /= 2;
    if (part < 0.1 || next.size() == 1 || model_.are_apart(next, workspace.model)) return next;
  }
}

void ContactFit::optimise(const VectorXd& changes, std::vector<EllipticContact> contacts,
                          int iterations, Workspace& workspace, Result& result) const {
  for (EllipticContact& contact : contacts) keep_inside(contact);
  // A new contact may begin smaller, where it is in the way of others.
  for (int shrink = 0; shrink < 3 && !model_.are_apart(contacts, workspace.model); ++shrink) {
    contacts.back().log_size -= 0.4;
  }
  Point point;
  Point trial;
  result.converged = false;
  if (!linearise(changes, contacts, workspace, point)) {
    result.log_evidence = -std::numeric_limits<double>::infinity();
    return;
  }
  double damping = 0.01;
  for (int i = 0; i < iterations && !result.converged; ++i) {
    MatrixXd damped = point.curvature;
    damped.diagonal() +=
        damping * point.curvature.diagonal() + VectorXd::Constant(damped.rows(), 1e-9);
    const VectorXd step = -damped.llt().solve(point.gradient);
    const std::vector<EllipticContact> next = stepped(contacts, step, workspace);
    if (linearise(changes, next, workspace, trial) && trial.objective < point.objective) {
      result.converged = point.objective - trial.objective < least_gain;
      std::swap(point, trial);
      contacts = next;
      damping = std::max(1e-6, damping / 5);
    } else {
      // What a step would gain if all were linear.
      result.converged = -point.gradient.dot(step) / 2 < least_gain || damping > 1e4;
      damping = std::max(1e-3, damping * 8);
    }
  }
  result.contacts = std::move(contacts);
  result.discs = !options_.ellipses;
  result.misfit = point.misfit;
  result.log_evidence = log_evidence(point.objective, point.curvature, result.contacts.size());
  result.precision = std::move(point.curvature);
}

bool ContactFit::add_one(const VectorXd& changes, const Result& from, Workspace& workspace,
                         Result& out) const {
  VectorXd whitened;
  if (from.contacts.empty()) {
    whitened.noalias() = whitening_ * changes;
  } else {
    if (!derivatives_of(from.contacts, workspace)) return false;
    whitened.noalias() = whitening_ * (changes - workspace.change);
  }
  const bool first = from.contacts.empty();
  if (first) {
    workspace.weights = (1 + (soft * whitened.array()).square()).rsqrt();
    if (workspace.kept.size() > 0) workspace.weights.array() *= workspace.kept.array();
  }
  atoms_.best(whitened, workspace.weights, most_starts, prior_, workspace.starts);
  std::vector<std::vector<EllipticContact>> starts;
  for (const ContactAtoms::Start& start : workspace.starts) {
    if (start.gain < workspace.starts.front().gain - hopeless || start.gain < promising) break;
    starts.push_back(from.contacts);
    starts.back().push_back(start.contact);
  }
  if (starts.empty()) return false;
  const auto pairs = static_cast<double>(model_.pairs());
  if (options_.ellipses && from.misfit > pairs + 3 * std::sqrt(2 * pairs)) {
    for (std::size_t k = 0; k < from.contacts.size(); ++k) {
      if (from.contacts[k].log_size > prior_.log_size_mean ||
          from.contacts[k].stretch.norm() > prior_.stretch_deviation)
        starts.push_back(with_split(from.contacts, k));
    }
  }
  bool any = false;
  for (std::vector<EllipticContact>& start : starts) {
    Result result;
    optimise(changes, std::move(start), first_steps, workspace, result);
    if (result.contacts.empty()) continue;
    if (!any || result.log_evidence > out.log_evidence) {
      out = std::move(result);
      any = true;
    }
  }
  if (first) {
    set_weights(workspace);
    if (any) out.converged = false;
  }
  if (any && !out.converged) {
    optimise(changes, std::move(out.contacts), options_.most_iterations - first_steps, workspace,
             out);
  }
  return any && !out.contacts.empty();
}

bool ContactFit::drop_or_join(const VectorXd& changes, Workspace& workspace, Found& found) const {
  const std::vector<EllipticContact> contacts = found.best.contacts;
  bool changed = false;
  const auto consider = [&](std::vector<EllipticContact> fewer) {
    Result result;
    optimise(changes, std::move(fewer), options_.most_iterations, workspace, result);
    if (result.contacts.empty()) return;
    if (result.log_evidence > found.best.log_evidence) {
      found.other = std::move(found.best);
      found.best = std::move(result);
      found.has_other = true;
      changed = true;
    }
  };
  // The last one was just found to be worth its while.
  for (std::size_t k = 0; k + 1 < contacts.size(); ++k) {
    std::vector<EllipticContact> fewer = contacts;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    if (contacts.size() > 2) consider(std::move(fewer));
    for (std::size_t other = k + 1; other < contacts.size(); ++other) {
      const double reach = std::exp(contacts[k].log_size) + std::exp(contacts[other].log_size);
      const bool same_sign = contacts[k].log_ratio * contacts[other].log_ratio > 0;
      if (!same_sign || (contacts[k].centre - contacts[other].centre).norm() > 1.3 * reach)
        continue;
      fewer = contacts;
      fewer[k] = joined(contacts[k], contacts[other]);
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(other));
      consider(std::move(fewer));
    }
  }
  return changed;
}

void ContactFit::fit(const VectorXd& changes, Workspace& workspace, Found& found) const {
  workspace.iterations = workspace.work = 0;
  found.best = Result{};
  found.best.misfit = uniform_noise_ > 0 ? changes.squaredNorm() / (uniform_noise_ * uniform_noise_)
                                         : (whitening_ * changes).squaredNorm();
  const double error = options_.model_error * options_.model_error * found.best.misfit;
  workspace.scale = 1 / std::sqrt(1 + error / static_cast<double>(model_.pairs()));
  set_weights(workspace);
  found.best.misfit *= workspace.scale * workspace.scale;
  found.best.log_evidence = log_evidence(found.best.misfit / 2, {}, 0);
  found.has_other = false;
  while (static_cast<int>(found.best.contacts.size()) < options_.most_contacts &&
         workspace.work < most_work) {
    Result more;
    if (!add_one(changes, found.best, workspace, more)) break;
    const bool better = more.log_evidence > found.best.log_evidence;
    Result& rest = better ? found.best : more;
    if (!found.has_other || rest.log_evidence > found.other.log_evidence || better) {
      found.other = std::move(rest);
      found.has_other = true;
    }
    if (!better) break;
    found.best = std::move(more);
  }
  if (found.best.contacts.size() > 1 && workspace.work < most_work)
    drop_or_join(changes, workspace, found);
  found.has_other =
      found.has_other && found.best.log_evidence - found.other.log_evidence < negligible;
  found.iterations = workspace.iterations;
}

void ContactFit::follow(const VectorXd& changes, std::span<const EllipticContact> start,
                        Workspace& workspace, Found& found) const {
  workspace.iterations = workspace.work = 0;
  const auto pairs = static_cast<double>(model_.pairs());
  if (!start.empty()) {
    workspace.scale = 1;
    set_weights(workspace);
    found.has_other = false;
    optimise(changes, {start.begin(), start.end()}, options_.most_iterations, workspace,
             found.best);
    // Four standard deviations of chi^2.
    if (!found.best.contacts.empty() && found.best.misfit < pairs + 4 * std::sqrt(2 * pairs)) {
      found.iterations = workspace.iterations;
      return;
    }
  }
  fit(changes, workspace, found);
}

}  // namespace ertbench
