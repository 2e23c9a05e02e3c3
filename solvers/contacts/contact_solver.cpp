#include "solvers/contacts/contact_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "forward/data/dataset_file.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

using Eigen::Index;

/// Frames of the validation set that the noise and the limit of the misfit are taken from.
constexpr std::uint64_t limit_frames = 400;
/// Chi^2 of a frame of the model itself exceeds its mean by this many standard deviations once in
/// some hundred thousand frames.
constexpr double unlikely = 5;
/// Over the largest misfit in the validation set, whose tail is long: that of shapes that are no
/// ellipses.
constexpr double limit_margin = 3;
/// A set without noise is taken to have this part of the reference voltages, 80 dB.
constexpr double least_noise = 1e-4;

/// Of one channel, from what the two channels of a pair differ by; V.
double noise_of(const DatasetFile& set) {
  const Frames voltages = set.voltages(0, std::min(set.size(), limit_frames));
  double sum = 0;
  const auto pairs = reciprocal_pairs(set.sensor());
  for (Index f = 0; f < voltages.rows(); ++f) {
    for (const auto& [a, b] : pairs) sum += std::pow(voltages(f, a) - voltages(f, b), 2) / 2;
  }
  const double count = static_cast<double>(voltages.rows()) * static_cast<double>(pairs.size());
  const double least = least_noise * set.reference_voltages().norm() /
                       std::sqrt(static_cast<double>(set.reference_voltages().size()));
  return std::max(least, std::sqrt(sum / count));
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
  prior_weight_ = read_weight(parameters, "prior_weight");
  options_.prior_weight = prior_weight_.value.value_or(1);
  noise_ = read_tunable(parameters, "noise", Range::positive());
  most_likely_ = parameters.choice_or("image", "mean", {"mean", "most-likely"}) == "most-likely";
  nuisances_ = Nuisances::from_json(parameters);
  choice_ = read_chosen(parameters, prior_weight_.value);
  mask_ = ChannelMask::from_json(parameters);
  if (mask_.detect && nuisances_.any()) {
    parameters.fail("nuisances", R"(cannot be had together with "channel_mask": "detect")");
  }
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
                        {"prior_weight", "auto"},
                        {"noise", "auto"},
                        {"image", most_likely_ ? "most-likely" : "mean"}};
  if (prior_weight_.value) out["prior_weight"] = *prior_weight_.value;
  if (noise_.value) out["noise"] = *noise_.value;
  nuisances_.add_to(out);
  mask_.add_to(out);
  if (choice_) out["chosen"] = to_json(*choice_);
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
  }
  if (noise_.automatic()) {
    if (input.validation == nullptr) {
      throw InputError(noise_.place +
                       ": \"auto\" needs a validation set; give the noise of a channel in volts");
    }
    noise_.value = noise_of(*input.validation);
  }
  prepare(input.sensor);
  if (prior_weight_.automatic()) choose_prior_weight(input);
  set_misfit_limit(input);
}

void ContactSolver::prepare(const Sensor& sensor) {
  sensor_ = sensor;
  pairs_ = reciprocal_pairs(sensor);
  electrodes_of_pairs_ = electrodes_of_pairs(sensor);
  fit_ = std::make_unique<ContactFit>(sensor, prior_,
                                      whitening_of(sensor, *noise_.value, nuisances_), options_);
  image_ = std::make_unique<ContactImage>(sensor);
}

void ContactSolver::choose_prior_weight(const FitInput& input) {
  const ValidationFrames frames = read_validation_frames(input, prior_weight_.place);
  const auto error_of = [&](double weight) {
    options_.prior_weight = weight;
    prepare(input.sensor);
    return mean_relative_error(*this, frames, input.threads);
  };
  choice_ = choose_number(prior_weight_.place, 0.1, 10, 2, static_cast<int>(frames.changes.rows()),
                          error_of);
  prior_weight_.value = options_.prior_weight = choice_->value;
  prepare(input.sensor);
}

void ContactSolver::set_misfit_limit(const FitInput& input) {
  const auto pairs = static_cast<double>(pairs_.size());
  misfit_limit_ = pairs + unlikely * std::sqrt(2 * pairs);
  if (input.validation == nullptr) return;
  const std::uint64_t count = std::min(input.validation->size(), limit_frames);
  const Frames voltages = input.validation->voltages(0, count);
  const Eigen::RowVectorXd reference = input.validation->reference_voltages().transpose();
  ContactFit::Workspace workspace;
  ContactFit::Found found;
  double largest = 0;
  for (Index f = 0; f < voltages.rows(); ++f) {
    const Eigen::RowVectorXd change = voltages.row(f) - reference;
    fit_frame(change.data(), 0, workspace, found);
    largest = std::max(largest, found.best.misfit);
  }
  misfit_limit_ = std::max(misfit_limit_, limit_margin * largest);
}

void ContactSolver::fit_frame(const double* changes, ElectrodeSet dead,
                              ContactFit::Workspace& workspace, ContactFit::Found& found) const {
  const auto count = static_cast<Index>(pairs_.size());
  Eigen::VectorXd means(count);
  const ElectrodeSet masked = mask_.electrodes | dead;
  workspace.kept.resize(masked == 0 ? 0 : count);
  for (Index p = 0; p < count; ++p) {
    const auto index = static_cast<std::size_t>(p);
    const bool kept = (electrodes_of_pairs_[index] & masked) == 0;
    // What a dead electrode reads may be anything, also NaN.
    means[p] = kept ? (changes[pairs_[index][0]] + changes[pairs_[index][1]]) / 2 : 0;
    if (masked != 0) workspace.kept[p] = kept ? 1 : 0;
  }
  fit_->fit(means, workspace, found);
}

void ContactSolver::reconstruct(FramesView changes, ImagesView images,
                                std::span<FrameReport> reports) const {
  thread_local ContactFit::Workspace workspace;
  thread_local ContactFit::Found found;
  for (Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    fit_frame(changes.row(f).data(), report.dead, workspace, found);
    if (most_likely_) {
      image_->most_likely(found.best.contacts, images.row(f));
    } else {
      image_->posterior_mean(found, images.row(f));
    }
    report.iterations = found.iterations;
    if (found.best.misfit > misfit_limit_ && misfit_limit_ > 0) report.reasons |= unexplained;
  }
}

void ContactSolver::find_contacts(FramesView changes,
                                  std::span<std::vector<FoundContact>> contacts) const {
  thread_local ContactFit::Workspace workspace;
  thread_local ContactFit::Found found;
  for (Index f = 0; f < changes.rows(); ++f) {
    std::vector<FoundContact>& out = contacts[static_cast<std::size_t>(f)];
    out.clear();
    if (!changes.row(f).allFinite()) continue;
    fit_frame(changes.row(f).data(), 0, workspace, found);
    const Eigen::MatrixXd& precision = found.best.precision;
    const Eigen::MatrixXd covariance =
        precision.llt().solve(Eigen::MatrixXd::Identity(precision.rows(), precision.cols()));
    for (std::size_t k = 0; k < found.best.contacts.size(); ++k) {
      const Index at = EllipticContact::parameters * static_cast<Index>(k);
      out.push_back(found_contact(found.best.contacts[k], sensor_.background,
                                  covariance.block<6, 6>(at, at)));
    }
    std::sort(out.begin(), out.end(),
              [](const FoundContact& a, const FoundContact& b) { return a.strength > b.strength; });
  }
}

void ContactSolver::save(const std::filesystem::path& file) const {
  create_solver_file(file, type, sensor_, parameters()).close();
}

void ContactSolver::load(const std::filesystem::path& file, const Sensor& sensor) {
  const nlohmann::json parameters = parameters_of_fit(open_solver_file(file, type, sensor));
  read(JsonObject(parameters, file.string(), "/parameters"));
  if (!noise_.value || !prior_weight_.value || misfit_limit_ <= 0) {
    throw InputError(file.string() +
                     ": /parameters: lacks what a fit leaves: noise, prior_weight, "
                     "learned");
  }
  prepare(sensor);
}

}  // namespace ertbench
