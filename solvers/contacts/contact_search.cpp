#include "solvers/contacts/contact_search.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "solvers/contacts/contact_fit.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Longest step of each parameter.
EllipticContact::Vector step_limits() {
  EllipticContact::Vector out;
  out << 0.25, 0.25, 0.6, 0.3, 0.3, 1.2;
  return out;
}

constexpr int places = 15;  ///< along a side of the sheet's bounds
constexpr double atom_ratio = 0.5;
constexpr double largest_dipole = 0.9;  ///< |1 - f| / (1 + f) that a start may have

double dipole_of(double ratio) { return (1 - ratio) / (1 + ratio); }

/// Least gain of the best atom for which a further contact is tried; its six parameters cost more.
constexpr double promising = 6;
/// Steps from each of several starts before only the best one continues.
constexpr int first_steps = 5;
constexpr int most_starts = 2;
/// Starts with a gain this much below the best are skipped; started fits this far behind stop.
constexpr double hopeless = 12;
constexpr double behind = 20;
/// The best start of a further contact is dropped if it is this far behind the present contacts.
constexpr double lost = 30;
/// Accuracy of fits, relative to their excess misfit, while further contacts may be added.
constexpr double looseness = 0.02;
/// Steps of the final, accurate fit.
constexpr int last_steps = 10;
/// No other number of contacts is tried after this much work (of ContactFit::most_work). Frames
/// that a few ellipses do not explain would go on adding contacts ever closer to each other.
constexpr int much_work = 1600;
/// Until the first contact is located, this share of each channel's voltage counts as noise: large
/// voltages next to electrodes change too fast for a start to be near.
constexpr double soft = 0.4;
/// Standard deviations of chi^2 beyond which noise alone does not explain a frame.
constexpr double unexplained_by = 10;
/// The second best number of contacts does not enter the image if its evidence is lower by this
/// much; a fit that stays behind by `hardly_counts` stops early.
constexpr double negligible = 6;
constexpr double hardly_counts = 2;
/// The contacts of the frame before are kept if their misfit is at most this factor above that of
/// the last search, and if dropping any of them costs at least `needed`, the price of its six
/// parameters.
constexpr double worse_than_searched = 1.5;
constexpr double needed = 12;

/// Misfit at this many standard deviations above the mean of chi^2.
double explained(double pairs, double deviations) {
  return pairs + deviations * std::sqrt(2 * pairs);
}

}  // namespace

double step_share(const Eigen::VectorXd& step) {
  const EllipticContact::Vector limits = step_limits();
  double longest = 1;
  for (Eigen::Index i = 0; i < step.size(); ++i) {
    longest = std::max(longest, std::abs(step[i]) / limits[i % EllipticContact::parameters]);
  }
  return 1 / longest;
}

std::vector<EllipticContact> moved(std::span<const EllipticContact> contacts,
                                   const Eigen::VectorXd& step) {
  const double share = step_share(step);
  std::vector<EllipticContact> out;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    out.push_back(EllipticContact::from(
        contacts[k].vector() +
        share * step.segment<EllipticContact::parameters>(EllipticContact::parameters *
                                                          static_cast<Eigen::Index>(k))));
  }
  return out;
}

EllipticContact joined(const EllipticContact& a, const EllipticContact& b) {
  const double share = a.area() / (a.area() + b.area());
  EllipticContact out;
  out.centre = share * a.centre + (1 - share) * b.centre;
  const auto moments = [&](const EllipticContact& c) {
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(c.angle()).toRotationMatrix();
    const Eigen::Vector2d squares = c.half_axes().cwiseAbs2() / 4;
    const Eigen::Vector2d d = c.centre - out.centre;
    return Eigen::Matrix2d(turn * squares.asDiagonal() * turn.transpose() + d * d.transpose());
  };
  const Eigen::Matrix2d second = share * moments(a) + (1 - share) * moments(b);
  // exp(2 M) = 4 second.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(4 * second);
  const Eigen::Vector2d logs = axes.eigenvalues().array().log() / 2;
  const Eigen::Matrix2d m =
      axes.eigenvectors() * logs.asDiagonal() * axes.eigenvectors().transpose();
  out.log_size = m.trace() / 2;
  out.stretch = {(m(0, 0) - m(1, 1)) / 2, m(0, 1)};
  out.log_ratio = share * a.log_ratio + (1 - share) * b.log_ratio;
  return out;
}

std::vector<EllipticContact> with_split(std::span<const EllipticContact> contacts, std::size_t k) {
  std::vector<EllipticContact> out(contacts.begin(), contacts.end());
  const Eigen::Vector2d axes = contacts[k].half_axes();
  const double angle = contacts[k].angle();
  const Eigen::Vector2d step = 0.55 * axes.x() * Eigen::Vector2d(std::cos(angle), std::sin(angle));
  EllipticContact part = contacts[k];
  part.stretch.setZero();
  part.log_size = std::log(std::min(0.45 * axes.x(), axes.y()));
  part.centre = contacts[k].centre + step;
  out[k] = part;
  part.centre = contacts[k].centre - step;
  out.push_back(part);
  return out;
}

ContactAtoms::ContactAtoms(const EllipseModel& model, const MatrixXd& whitening) {
  const Sheet& sheet = *model.sensor().sheet;
  const Eigen::AlignedBox2d& box = sheet.bounds();
  const double shorter = box.sizes().minCoeff() / 2;
  EllipseModel::Workspace workspace;
  std::vector<VectorXd> rows;
  VectorXd change(model.pairs());
  for (const double radius : {0.08, 0.16, 0.3}) {
    for (int i = 0; i < places; ++i) {
      for (int j = 0; j < places; ++j) {
        EllipticContact atom;
        atom.log_size = std::log(radius * shorter);
        atom.log_ratio = std::log(atom_ratio);
        // A grid from border to border, within reach of a disc of this size.
        const Eigen::Vector2d part(i / (places - 1.0), j / (places - 1.0));
        const double margin = (1.02 * radius + 0.01) * shorter;
        atom.centre =
            box.min().array() + margin + part.array() * (box.sizes().array() - 2 * margin);
        if (!model.place(std::span(&atom, 1), workspace)) continue;
        model.evaluate(workspace, change);
        contacts_.push_back(atom);
        rows.emplace_back(whitening * change);
      }
    }
  }
  atoms_.resize(static_cast<Index>(rows.size()), model.pairs());
  for (Index k = 0; k < atoms_.rows(); ++k) {
    atoms_.row(k) = rows[static_cast<std::size_t>(k)].cast<float>();
  }
  squares_ = atoms_.cwiseAbs2();
}

void ContactAtoms::best(const VectorXd& residual, const VectorXd& weights, int count,
                        const ContactPrior& prior, std::vector<Start>& out) const {
  out.clear();
  thread_local Eigen::VectorXf weight;
  thread_local Eigen::VectorXf products;
  thread_local Eigen::VectorXf norms;
  thread_local Eigen::VectorXf squares;
  weight = weights.cwiseAbs2().cast<float>();
  norms.noalias() = squares_ * weight;
  weight.array() *= residual.cast<float>().array();
  products.noalias() = atoms_ * weight;
  squares = products.cwiseAbs2().cwiseQuotient(norms);
  // Atoms have a lower conductivity; a negative product means a higher one.
  if (!prior.may_rise) squares = (products.array() > 0).select(squares, 0);
  if (!prior.may_fall) squares = (products.array() < 0).select(squares, 0);
  while (static_cast<int>(out.size()) < count) {
    Index k = 0;
    const double square = squares.maxCoeff(&k);
    if (square <= 0) return;
    Start start{contacts_[static_cast<std::size_t>(k)], square / 2};
    const double amplitude = products[k] / norms[k];
    const double dipole =
        std::clamp(amplitude * dipole_of(atom_ratio), -largest_dipole, largest_dipole);
    start.contact.log_ratio = std::log((1 - dipole) / (1 + dipole));
    out.push_back(start);
    const double apart = std::max(0.15, std::exp(start.contact.log_size) / 2);
    for (Index other = 0; other < squares.size(); ++other) {
      const Eigen::Vector2d step =
          contacts_[static_cast<std::size_t>(other)].centre - start.contact.centre;
      if (step.squaredNorm() < apart * apart) squares[other] = 0;
    }
  }
}

// ContactFit's search for the number of contacts. Gains and differences below are of log posterior
// or log evidence.

void ContactFit::begin(const VectorXd& changes, Workspace& workspace) const {
  workspace.iterations = workspace.work = 0;
  workspace.coarse = false;
  workspace.unexplained = uniform_noise_ > 0
                              ? changes.squaredNorm() / (uniform_noise_ * uniform_noise_)
                              : whitened_residual_of(changes, {}, workspace).squaredNorm();
  const double error = options_.model_error * options_.model_error * workspace.unexplained;
  workspace.scale = 1 / std::sqrt(1 + error / pairs_in_use(workspace));
  set_weights(workspace);
}

VectorXd ContactFit::whitened_residual_of(const VectorXd& changes,
                                          std::span<const EllipticContact> contacts,
                                          Workspace& workspace) const {
  if (contacts.empty() || !model_.place(contacts, workspace.model)) {
    VectorXd whitened = whitening_ * changes;
    project(workspace, whitened);
    return whitened;
  }
  whitened_residual(changes, workspace);
  return workspace.whitened;
}

bool ContactFit::add_one(const VectorXd& changes, const Result& from, Workspace& workspace,
                         Result& out) const {
  const VectorXd whitened = whitened_residual_of(changes, from.contacts, workspace);
  const bool first = from.contacts.empty();
  if (first) {
    workspace.weights = (1 + (soft * whitened.array()).square()).rsqrt();
    weigh_pairs(workspace);
  }
  atoms_.best(whitened, workspace.weights, most_starts, prior_, workspace.starts);
  std::vector<std::vector<EllipticContact>> starts;
  for (const ContactAtoms::Start& start : workspace.starts) {
    if (start.gain < workspace.starts.front().gain - hopeless || start.gain < promising) break;
    starts.push_back(from.contacts);
    starts.back().push_back(start.contact);
  }
  if (starts.empty()) return false;
  const double pairs = pairs_in_use(workspace);
  if (options_.ellipses && from.misfit > explained(pairs, 3)) {
    for (std::size_t k = 0; k < from.contacts.size(); ++k) {
      if (from.contacts[k].log_size > prior_.log_size_mean ||
          from.contacts[k].stretch.norm() > prior_.stretch_deviation) {
        starts.push_back(with_split(from.contacts, k));
      }
    }
  }
  bool any = false;
  workspace.coarse = true;
  for (std::vector<EllipticContact>& start : starts) {
    if (any && (workspace.work > much_work || (!first && out.misfit < explained(pairs, 2)))) break;
    Effort effort{first_steps};
    if (any && !first) effort.least_evidence = out.log_evidence - behind;
    Result result;
    optimise(changes, std::move(start), effort, workspace, result);
    if (result.contacts.empty()) continue;
    if (!any || result.log_evidence > out.log_evidence) {
      out = std::move(result);
      any = true;
    }
  }
  workspace.coarse = false;
  if (first) set_weights(workspace);
  if (any && !first && out.log_evidence < from.log_evidence - lost) return false;
  if (any) {
    const Effort effort{options_.most_iterations - first_steps, looseness,
                        from.log_evidence - hardly_counts};
    optimise(changes, std::vector<EllipticContact>(out.contacts), effort, workspace, out);
  }
  return any && !out.contacts.empty();
}

void ContactFit::drop_or_join(const VectorXd& changes, Workspace& workspace, Found& found) const {
  const std::vector<EllipticContact> contacts = found.best.contacts;
  const auto consider = [&](std::vector<EllipticContact> fewer) {
    if (workspace.work > much_work) return;
    Result result;
    const Effort effort{options_.most_iterations, looseness,
                        found.best.log_evidence - hardly_counts};
    optimise(changes, std::move(fewer), effort, workspace, result);
    if (!result.contacts.empty() && result.log_evidence > found.best.log_evidence) {
      found.other = std::move(found.best);
      found.best = std::move(result);
      found.has_other = true;
    }
  };
  // The last contact was added just now, because the evidence is larger with it.
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
      if (!options_.ellipses) fewer[k].stretch.setZero();
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(other));
      consider(std::move(fewer));
    }
  }
}

void ContactFit::fit(const VectorXd& changes, Workspace& workspace, Found& found) const {
  begin(changes, workspace);
  found.best = Result{};
  found.best.misfit = workspace.unexplained * workspace.scale * workspace.scale;
  found.best.log_evidence = log_evidence(found.best.misfit / 2, {}, 0);
  found.has_other = false;
  while (static_cast<int>(found.best.contacts.size()) < options_.most_contacts &&
         workspace.work < much_work) {
    Result more;
    if (!add_one(changes, found.best, workspace, more)) break;
    // Two contacts may explain a frame that one explains no better than none. If the misfit without
    // contacts is far above the noise, the search goes on although the first contact gains nothing.
    const bool hopeful = found.best.contacts.empty() &&
                         found.best.misfit > explained(pairs_in_use(workspace), unexplained_by);
    const bool by_evidence = more.log_evidence > found.best.log_evidence;
    const bool better = hopeful || by_evidence;
    Result& rest = better ? found.best : more;
    // The empty set of contacts is then no candidate for the second best number.
    const bool next_best = !found.has_other || rest.log_evidence > found.other.log_evidence;
    if (by_evidence || (!better && next_best)) {
      found.other = std::move(rest);
      found.has_other = true;
    }
    if (!better) break;
    found.best = std::move(more);
  }
  if (found.best.contacts.size() > 1) drop_or_join(changes, workspace, found);
  if (!found.best.contacts.empty() && !found.best.settled && workspace.work < most_work) {
    const std::vector<EllipticContact> contacts = found.best.contacts;
    optimise(changes, contacts, {last_steps}, workspace, found.best);
  }
  found.has_other =
      found.has_other && found.best.log_evidence - found.other.log_evidence < negligible;
  found.iterations = workspace.iterations;
  found.searched_misfit = found.best.misfit;
}

void ContactFit::follow(const VectorXd& changes, const Result& last, Workspace& workspace,
                        Found& found) const {
  std::vector<EllipticContact> start = last.contacts;
  if (!start.empty()) {
    begin(changes, workspace);
    found.has_other = false;
    optimise(changes, std::move(start), {options_.most_iterations}, workspace, found.best);
    const double enough = std::max(explained(pairs_in_use(workspace), 4),
                                   worse_than_searched * found.searched_misfit);
    if (!found.best.contacts.empty() && found.best.misfit < enough &&
        are_needed(changes, found.best, workspace)) {
      found.iterations = workspace.iterations;
      return;
    }
  }
  fit(changes, workspace, found);
}

bool ContactFit::are_needed(const VectorXd& changes, const Result& result,
                            Workspace& workspace) const {
  for (std::size_t k = 0; k < result.contacts.size(); ++k) {
    std::vector<EllipticContact> fewer = result.contacts;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(k));
    double misfit = workspace.unexplained * workspace.scale * workspace.scale;
    if (!fewer.empty()) {
      if (!model_.place(fewer, workspace.model)) return false;
      whitened_residual(changes, workspace);
      misfit = workspace.whitened.cwiseProduct(workspace.weights).squaredNorm();
    }
    if (misfit - result.misfit < 2 * needed) return false;
  }
  return true;
}

}  // namespace ertbench
