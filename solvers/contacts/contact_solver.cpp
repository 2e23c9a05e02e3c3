#include "solvers/contacts/contact_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "solvers/contacts/contact_image.h"
#include "solvers/front/frame_check.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

using Eigen::Index;

/// Standard deviations by which chi^2 of a frame of the model itself exceeds its mean once in some
/// hundred thousand frames.
constexpr double unlikely = 5;
/// Share of frames like those of the validation set that may be called unexplained. Shapes other
/// than ellipses give the misfit a long tail; its quantile from some hundred frames is multiplied
/// by the margin.
constexpr double tail_share = 1.0 / 1200;
constexpr double limit_margin = 2;
/// Largest number of fits of a frame to estimate the factor common to all voltages, and the rest of
/// it, relative to the noise, at which they stop.
constexpr int most_factors = 4;
constexpr double little = 0.1;
/// Least standard deviation of the logarithm of a conductivity ratio that the user gives.
constexpr double least_known = 0.02;

/// Both channels of a reciprocal pair have the noise of Student's t with this many degrees of
/// freedom, whose precision is that of the pair. Given their difference in deviations, the mean of
/// this precision is the weight of their sum; a sound pair has 1 at most.
double weight_of(double difference) {
  constexpr double freedom = 4;
  return std::min(1.0, (freedom + 1) / (freedom + difference * difference));
}

FoundContact found_contact(const EllipticContact& contact, double background,
                           const Eigen::Matrix<double, 6, 6>& covariance) {
  FoundContact out;
  out.place = contact.centre;
  out.area = contact.area();
  out.peak = std::abs(contact.ratio() - 1) * background;
  out.strength = out.peak * out.area;
  out.place_deviation = covariance.diagonal().head<2>().cwiseMax(0).cwiseSqrt();
  // d log(strength) = 2 d log_size + ratio / (ratio - 1) d log_ratio.
  Eigen::Matrix<double, 6, 1> slope = Eigen::Matrix<double, 6, 1>::Zero();
  slope[2] = 2;
  slope[5] = contact.ratio() / std::min(-1e-9, -std::abs(contact.ratio() - 1)) *
             (contact.ratio() > 1 ? -1 : 1);
  out.strength_deviation = out.strength * std::sqrt(std::max(0.0, slope.dot(covariance * slope)));
  return out;
}

}  // namespace

ContactSolver::ContactSolver(JsonObject parameters) { read(std::move(parameters)); }

void ContactSolver::read(JsonObject parameters) {
  options_.ellipses = parameters.choice_or("shape", "ellipse", {"ellipse", "disc"}) == "ellipse";
  options_.most_contacts = parameters.integer_or("most_contacts", 4, 1, 8);
  options_.model_error = parameters.number_or("model_error", 0.02, {0, 0.5});
  learns_prior_ = parameters.choice_or("prior", "broad", {"broad", "training"}) == "training";
  if (parameters.has("conductivity_ratio")) {
    const std::vector<double> both = parameters.numbers("conductivity_ratio", 2, Range::positive());
    if (both[0] > both[1] || (both[0] <= 1 && both[1] >= 1)) {
      parameters.fail("conductivity_ratio",
                      "must be [low, high], both less than 1 or both greater, low first");
    }
    known_ratio_ = {both[0], both[1]};
    know_ratio();
  }
  prior_weight_ = read_weight(parameters, "prior_weight");
  options_.prior_weight = prior_weight_.value.value_or(1);
  noise_ = read_tunable(parameters, "noise", Range::positive());
  most_likely_ = parameters.choice_or("image", "mean", {"mean", "most-likely"}) == "most-likely";
  nuisances_ = Nuisances::from_json(parameters);
  read_chosen(parameters, prior_weight_);
  mask_ = ChannelMask::from_json(parameters);
  student_ = parameters.choice_or("likelihood", "normal", {"normal", "student"}) == "student";
  if (parameters.has("learned")) {
    JsonObject learned = parameters.object("learned");
    prior_ = contact_prior_from_json(learned.object("prior"));
    misfit_limit_ = learned.number("misfit_limit", {0, 1e12});
    learned.finish();
  }
  parameters.finish();
}

nlohmann::json ContactSolver::parameters() const {
  nlohmann::json out = {{"shape", options_.ellipses ? "ellipse" : "disc"},
                        {"most_contacts", options_.most_contacts},
                        {"model_error", options_.model_error},
                        {"prior", learns_prior_ ? "training" : "broad"},
                        {"image", most_likely_ ? "most-likely" : "mean"}};
  prior_weight_.add_to(out, "prior_weight");
  noise_.add_to(out, "noise");
  if (known_ratio_) out["conductivity_ratio"] = {known_ratio_->first, known_ratio_->second};
  nuisances_.add_to(out);
  mask_.add_to(out);
  if (student_) out["likelihood"] = "student";
  if (misfit_limit_ > 0) {
    out["learned"] = {{"prior", to_json(prior_)}, {"misfit_limit", misfit_limit_}};
  }
  return out;
}

void ContactSolver::check(const Sensor& sensor) const { mask_.check(sensor); }

void ContactSolver::fit(const FitInput& input) {
  if (learns_prior_) {
    if (input.training == nullptr) {
      throw InputError(prior_weight_.place +
                       R"(: "prior": "training" needs a training set; give "broad")");
    }
    prior_ = ContactPrior::of(*input.training);
    know_ratio();
  }
  if (noise_.automatic()) {
    if (input.validation == nullptr) {
      throw InputError(noise_.place +
                       ": \"auto\" needs a validation set, or two frames without contact or more "
                       "(`reconstruct --background`); give the noise of a channel in volts");
    }
    noise_.value = noise_of_channel(*input.validation, mask_.electrodes);
    if (!noise_.value) {
      throw InputError(
          noise_.place +
          ": \"auto\" cannot be told from measured frames of which no two channels are "
          "reciprocal; give the noise of a channel in volts");
    }
  }
  prepare(input.sensor);
  if (prior_weight_.automatic()) choose_prior_weight(input);
  set_misfit_limit(input);
}

void ContactSolver::know_ratio() {
  if (!known_ratio_) return;
  const double low = std::log(known_ratio_->first);
  const double high = std::log(known_ratio_->second);
  prior_.log_ratio_mean = std::abs(low + high) / 2;
  prior_.log_ratio_deviation = std::max(least_known, (high - low) / std::sqrt(12.0));
  prior_.may_fall = high < 0;
  prior_.may_rise = low > 0;
}

void ContactSolver::prepare(const Sensor& sensor) {
  sensor_ = sensor;
  pairs_ = reciprocal_pairs(sensor);
  electrodes_of_pairs_ = electrodes_of_pairs(sensor);
  const Eigen::MatrixXd whitening = whitening_of(sensor, *noise_.value, nuisances_);
  fit_ = std::make_unique<ContactFit>(sensor, prior_, whitening, options_);
  if (nuisances_.factor() > 0) {
    const Eigen::VectorXd reference = BorderModel(sensor).reference_voltages();
    reference_.resize(static_cast<Index>(pairs_.size()));
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      reference_[static_cast<Index>(p)] = (reference[pairs_[p][0]] + reference[pairs_[p][1]]) / 2;
    }
    whitened_reference_ = whitening * reference_;
  }
  image_ = std::make_unique<ContactImage>(sensor);
}

void ContactSolver::choose_prior_weight(const FitInput& input) {
  const ValidationFrames frames = read_validation_frames(input, prior_weight_.place);
  const auto set_weight = [&](double weight) {
    options_.prior_weight = weight;
    prepare(input.sensor);
  };
  prior_weight_.choose(*this, frames, input.threads, {0.1, 10}, 2, set_weight);
  set_weight(*prior_weight_.value);
}

void ContactSolver::set_misfit_limit(const FitInput& input) {
  const auto pairs = static_cast<double>(pairs_.size());
  misfit_limit_ = pairs + unlikely * std::sqrt(2 * pairs);
  if (input.validation == nullptr) return;
  const std::uint64_t count = std::min(input.validation->size(), judged_frames);
  const Frames voltages = input.validation->voltages(0, count);
  const std::vector<Index> frames = frames_like(*input.validation, count, known_ratio_);
  const Eigen::RowVectorXd reference = input.validation->reference_voltages().transpose();
  Fitted fitted;
  Eigen::VectorXd misfits(static_cast<Index>(frames.size()));
  for (Index f = 0; f < misfits.size(); ++f) {
    const Eigen::RowVectorXd change = voltages.row(frames[static_cast<std::size_t>(f)]) - reference;
    fit_frame(change.data(), 0, false, fitted);
    misfits[f] = fitted.found.best.misfit;
  }
  misfit_limit_ = std::max(misfit_limit_, limit_margin * tail_limit(misfits, tail_share));
}

bool ContactSolver::is_finite(const double* changes, ElectrodeSet dead) const {
  const ElectrodeSet masked = mask_.electrodes | dead;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if ((electrodes_of_pairs_[p] & masked) != 0) continue;
    if (!std::isfinite(changes[pairs_[p][0]] + changes[pairs_[p][1]])) return false;
  }
  return true;
}

void ContactSolver::fit_frame(const double* changes, ElectrodeSet dead, bool followed,
                              Fitted& fitted) const {
  ContactFit::Workspace& workspace = fitted.workspace;
  const auto count = static_cast<Index>(pairs_.size());
  Eigen::VectorXd means(count);
  const ElectrodeSet masked = mask_.electrodes | dead;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(masked == 0 && !student_ ? 0 : count);
  for (Index p = 0; p < count; ++p) {
    const auto index = static_cast<std::size_t>(p);
    const bool kept = (electrodes_of_pairs_[index] & masked) == 0;
    // Channels of a dead electrode may read anything, also NaN.
    means[p] = kept ? (changes[pairs_[index][0]] + changes[pairs_[index][1]]) / 2 : 0;
    if (!kept) weights[p] = 0;
    if (kept && student_) {
      const double apart = changes[pairs_[index][0]] - changes[pairs_[index][1]];
      weights[p] = weight_of(apart / (std::numbers::sqrt2 * *noise_.value));
    }
  }
  fit_->set_kept(weights.cwiseSqrt(), workspace);
  // In a stream the factor of the last frame is the first guess.
  const double factor = followed ? 1 / (1 + fitted.level) : 1;
  fitted.level = 0;
  if (nuisances_.factor() > 0) {
    fit_factor(means, factor, followed, fitted);
  } else if (followed) {
    fit_->follow(means, fitted.found.best, workspace, fitted.found);
  } else {
    fit_->fit(means, workspace, fitted.found);
  }
}

void ContactSolver::fit_factor(const Eigen::VectorXd& means, double factor, bool followed,
                               Fitted& fitted) const {
  ContactFit::Found& found = fitted.found;
  const double deviation = nuisances_.factor();
  int iterations = 0;
  for (int i = 0; i < most_factors; ++i) {
    const Eigen::VectorXd rest = (reference_ + means) / factor - reference_;
    if (i == 0 && !followed) {
      fit_->fit(rest, fitted.workspace, found);
    } else {
      fit_->follow(rest, found.best, fitted.workspace, found);
    }
    iterations += found.iterations;
    // Posterior mean of the factor given the residual r: deviation^2 n' C^-1 r.
    const double more = deviation * deviation *
                        whitened_reference_.dot(fit_->whitened_residual_of(
                            rest, found.best.contacts, fitted.workspace));
    factor *= 1 + more;
    if (std::abs(more) * rest.norm() * std::numbers::sqrt2 < little * *noise_.value) break;
  }
  found.iterations = iterations;
  // The prior deviations divide the factor between gain and level.
  const double share = std::pow(nuisances_.level / deviation, 2);
  fitted.level = std::pow(factor, -share) - 1;
}

void ContactSolver::draw(const Fitted& fitted, Eigen::Ref<Eigen::RowVectorXd> image,
                         FrameReport& report) const {
  const ContactFit::Found& found = fitted.found;
  if (most_likely_) {
    image_->most_likely(found.best.contacts, image);
  } else {
    image_->posterior_mean(found, image);
  }
  report.iterations = found.iterations;
  report.level = fitted.level;
  const Eigen::VectorXd& kept = fitted.workspace.kept;
  // Share of the pairs.
  const double in_use = kept.size() > 0 ? kept.squaredNorm() / static_cast<double>(kept.size()) : 1;
  if (found.best.misfit > in_use * misfit_limit_ && misfit_limit_ > 0) {
    report.reasons |= unexplained;
  }
}

void ContactSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) const {
  thread_local Fitted fitted;
  for (Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    fit_frame(changes.row(f).data(), report.dead, false, fitted);
    draw(fitted, images.row(f), report);
  }
}

class ContactSolver::Stream final : public FrameStream {
 public:
  explicit Stream(const ContactSolver& solver) : solver_(solver) {}

  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport> reports) override {
    for (Index f = 0; f < changes.rows(); ++f) {
      contacts_.clear();
      FrameReport& report = reports[static_cast<std::size_t>(f)];
      if (!solver_.is_finite(changes.row(f).data(), report.dead)) {
        images.row(f).setZero();
        continue;
      }
      solver_.fit_frame(changes.row(f).data(), report.dead, followed_, fitted_);
      followed_ = true;
      solver_.draw(fitted_, images.row(f), report);
      solver_.list_contacts(fitted_.found, contacts_);
    }
  }
  const std::vector<FoundContact>* contacts() const override { return &contacts_; }

 private:
  const ContactSolver& solver_;
  Fitted fitted_;
  bool followed_ = false;  ///< there was a frame before
  std::vector<FoundContact> contacts_;
};

std::unique_ptr<FrameStream> ContactSolver::open_stream() const {
  return std::make_unique<Stream>(*this);
}

void ContactSolver::list_contacts(const ContactFit::Found& found,
                                  std::vector<FoundContact>& out) const {
  out.clear();
  const Eigen::MatrixXd& precision = found.best.precision;
  const Eigen::MatrixXd covariance =
      precision.llt().solve(Eigen::MatrixXd::Identity(precision.rows(), precision.cols()));
  for (std::size_t k = 0; k < found.best.contacts.size(); ++k) {
    const Index at = EllipticContact::parameters * static_cast<Index>(k);
    out.push_back(
        found_contact(found.best.contacts[k], sensor_.background, covariance.block<6, 6>(at, at)));
  }
  std::sort(out.begin(), out.end(),
            [](const FoundContact& a, const FoundContact& b) { return a.strength > b.strength; });
}

void ContactSolver::find_contacts(FramesView changes,
                                  std::span<std::vector<FoundContact>> contacts) const {
  thread_local Fitted fitted;
  for (Index f = 0; f < changes.rows(); ++f) {
    std::vector<FoundContact>& out = contacts[static_cast<std::size_t>(f)];
    out.clear();
    if (!is_finite(changes.row(f).data(), 0)) continue;
    fit_frame(changes.row(f).data(), 0, false, fitted);
    list_contacts(fitted.found, out);
  }
}

void ContactSolver::save(const std::filesystem::path& file) const {
  create_solver_file(file, type, sensor_, parameters()).close();
}

void ContactSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  read(JsonObject(parameters_of_fit(open_solver_file(file, type, sensor)), file.string(),
                  "/parameters"));
  if (!noise_.value || !prior_weight_.value || misfit_limit_ <= 0) {
    throw InputError(file.string() +
                     ": /parameters: lacks what a fit leaves: noise, prior_weight, learned");
  }
  prepare(sensor);
}

std::vector<SolverType> contact_solvers() {
  SolverInfo info;
  info.summary =
      "contacts as unknowns: ellipses or discs, as many as the evidence asks for, fitted to the "
      "exact model of the sheet";
  info.parameters = {
      {"shape", "\"ellipse\" (the default) or \"disc\""},
      {"most_contacts", "in a frame, 1 ... 8; default 4"},
      {"model_error",
       "what contacts that are no ellipses leave, root mean square over that of the frame's "
       "change; counts as noise, 0 ... 0.5; default 0.02"},
      {"prior",
       "of a contact's size, stretch and ratio: \"broad\" (the default) or \"training\", that of "
       "the contacts in the training set"},
      {"prior_weight",
       "multiplies the prior's inverse variances, > 0 or \"auto\"; default \"auto\""},
      {"noise",
       "standard deviation of a channel, V, or \"auto\" (the default): from what the reciprocal "
       "channels of the validation set differ by"},
      {"conductivity_ratio",
       "[low, high] of every contact's conductivity over the background's, both below 1 or both "
       "above, where that is known; default none"},
      {"image",
       "\"mean\" (the default) of the posterior, or \"most-likely\": the contacts of its maximum"},
      {"likelihood",
       "of the noise: \"normal\" (the default), or \"student\": of Student's t, by which a channel "
       "that differs from its reciprocal one counts less"},
      Nuisances::parameter(),
      ChannelMask::parameter()};
  info.make = make_from_json<ContactSolver>;
  info.probes = {"{}", R"({"shape": "disc", "prior": "training", "image": "most-likely"})"};
  // Last bits decide whether a step is taken.
  info.comparison = ImageComparison::rounding;
  return {{ContactSolver::type, info}};
}

}  // namespace ertbench
