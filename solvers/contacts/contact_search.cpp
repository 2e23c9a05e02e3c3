// How many contacts a frame has: ContactFit's search.

#include <algorithm>
#include <cmath>

#include "solvers/contacts/contact_fit.h"
#include "solvers/contacts/contact_moves.h"

namespace ertbench {
namespace {

using Eigen::VectorXd;

/// A further contact is tried where the best atom promises more of the logarithm of the posterior:
/// no contact's six numbers cost less.
constexpr double promising = 6;
/// Steps from each of several starts before the best of them goes on.
constexpr int first_steps = 5;
constexpr int most_starts = 2;
/// Starts that promise so much less than the best are not tried, and one that is so far behind is
/// given up.
constexpr double hopeless = 12;
constexpr double behind = 20;
/// So far behind the contacts that are there already, the best start of one more is given up.
constexpr double lost = 30;
/// While a further contact is still asked for, the fit of those that are there need not be better
/// than this part of what they leave unexplained.
constexpr double looseness = 0.02;
/// Of the last fit, where those before were loose.
constexpr int last_steps = 10;
/// No other number of contacts is begun where a frame's iterations have taken so much
/// (ContactFit::most_work): frames that no few ellipses explain would go on, with contacts ever
/// closer to each other.
constexpr int much_work = 1600;
/// While the first contact's whereabouts are not known, a channel counts with this part of its
/// voltage as noise: large voltages next to electrodes change too fast for a start to be near.
constexpr double soft = 0.4;
/// Standard deviations of chi^2 beyond which noise alone does not explain a frame.
constexpr double unexplained_by = 10;
/// A number of contacts whose evidence is so much less has no part in the image, and one that comes
/// no closer than to a part of that is not looked at to the end.
constexpr double negligible = 6;
constexpr double hardly_counts = 2;
/// The contacts of the frame before go on as long as they explain this frame as well as contacts
/// did when their number was last looked for, but for this factor, and each of them explains more
/// of it than this much of the logarithm of the posterior: what its six numbers cost.
constexpr double worse_than_searched = 1.5;
constexpr double needed = 12;

/// Misfit that so many standard deviations of chi^2 explain.
double explained(double pairs, double deviations) {
  return pairs + deviations * std::sqrt(2 * pairs);
}

}  // namespace

void ContactFit::begin(const VectorXd& changes, Workspace& workspace) const {
  workspace.iterations = workspace.work = 0;
  workspace.coarse = false;
  workspace.unexplained = uniform_noise_ > 0
                              ? changes.squaredNorm() / (uniform_noise_ * uniform_noise_)
                              : (whitening_ * changes).squaredNorm();
  const double error = options_.model_error * options_.model_error * workspace.unexplained;
  workspace.scale = 1 / std::sqrt(1 + error / pairs_in_use(workspace));
  set_weights(workspace);
}

VectorXd ContactFit::whitened_residual_of(const VectorXd& changes,
                                          std::span<const EllipticContact> contacts,
                                          Workspace& workspace) const {
  if (contacts.empty() || !model_.place(contacts, workspace.model)) return whitening_ * changes;
  whitened_residual(changes, workspace);
  return workspace.whitened;
}

bool ContactFit::add_one(const VectorXd& changes, const Result& from, Workspace& workspace,
                         Result& out) const {
  const VectorXd whitened = whitened_residual_of(changes, from.contacts, workspace);
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
    // One contact in the place of two may explain a frame no better than none does, which says
    // nothing of two: a frame that is far from explained is not left without contacts.
    const bool hopeful = found.best.contacts.empty() &&
                         found.best.misfit > explained(pairs_in_use(workspace), unexplained_by);
    const bool by_evidence = more.log_evidence > found.best.log_evidence;
    const bool better = hopeful || by_evidence;
    Result& rest = better ? found.best : more;
    // No contact has no part in the image of a frame that is not left without contacts.
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
