#include "solvers/iterated/gauss_newton.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/statistics.h"
#include "forward/data/dataset_file.h"
#include "forward/fem/forward_model.h"
#include "solvers/decompositions.h"
#include "solvers/linear/masked_inverse.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

constexpr int halvings = 12;
constexpr double sufficient = 1e-4;  ///< part of the promised decrease that a step must bring
/// Predicted relative decreases below this are rounding.
constexpr double least_decrease = 1e-13;

/// Smoothing of the total variation over the background: larger differences count linearly.
constexpr double smoothing = 0.01;
/// Directions of the training images with less than this share of the strongest are dropped.
constexpr double least_variance = 1e-4;

/// E with E E^T = E[t t^T] over the training images, without its weakest directions.
Eigen::MatrixXd shaping_of(const DatasetFile& set, const BoundedConductivity& bounds) {
  constexpr std::uint64_t read_at_once = 1000;
  const Eigen::Index pixels = set.sensor().pixels();
  Eigen::MatrixXd moment = Eigen::MatrixXd::Zero(pixels, pixels);
  for (std::uint64_t first = 0; first < set.size(); first += read_at_once) {
    const std::uint64_t count = std::min(read_at_once, set.size() - first);
    const Images t = bounds.variable(set.conductivity(first, count).array());
    moment.selfadjointView<Eigen::Lower>().rankUpdate(t.transpose());
  }
  moment /= static_cast<double>(set.size());
  const SymmetricEigen eigen = symmetric_eigen(moment);
  const double least = least_variance * eigen.values[pixels - 1];
  const auto kept = (eigen.values.array() >= least).count();
  return eigen.vectors.rightCols(kept) *
         eigen.values.tail(kept).cwiseMax(0).cwiseSqrt().asDiagonal();
}

}  // namespace

GaussNewtonIteration::GaussNewtonIteration(const Sensor& sensor, const BoundedConductivity& bounds,
                                           std::unique_ptr<Penalty> penalty,
                                           const RowMajorMatrix& background_jacobian)
    : reciprocity_(sensor),
      background_(sensor.background),
      sheet_(sensor),
      bounds_(bounds),
      penalty_(std::move(penalty)),
      background_jacobian_(background_jacobian),
      t_(sensor.pixels()),
      t_trial_(sensor.pixels()) {}

double GaussNewtonIteration::set(const Eigen::VectorXd& z, const std::vector<Eigen::Index>& kept) {
  penalty_->image(z, t_trial_);
  bounds_.ratios(t_trial_, ratio_, slope_);
  sheet_.set_conductivity(ratio_);
  sheet_.changes(kept, modelled_);
  residual_ = data_ - modelled_;
  return residual_.squaredNorm() / 2 + penalty_->value(z);
}

double GaussNewtonIteration::noise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const std::vector<Eigen::Index>& kept) const {
  double square = 0;
  for (const Eigen::Index p : kept) {
    const auto& [a, b] = reciprocity_.pair(p);
    square += (change[a] - change[b]) * (change[a] - change[b]) / 2;
  }
  return std::sqrt(square);
}

void GaussNewtonIteration::minimise(const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                    const std::vector<Eigen::Index>& kept,
                                    const GaussNewtonOptions& options,
                                    Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report) {
  image.setZero();
  const auto count = static_cast<Eigen::Index>(kept.size());
  data_.resize(count);
  modelled_.setZero(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Index p = kept[static_cast<std::size_t>(i)];
    const auto& [a, b] = reciprocity_.pair(p);
    data_[i] = (change[a] + change[b]) / 2 * reciprocity_.of_mean(p);
  }
  if (!data_.allFinite()) {
    report.status = FrameStatus::undefined;
    return;
  }
  z_.setZero(penalty_->coordinates());
  t_.setZero();
  bounds_.ratios(t_, ratio_, slope_);
  residual_ = data_;
  objective_ = residual_.squaredNorm() / 2;
  const double done = options.discrepancy > 0 ? options.discrepancy * noise(change, kept) : 0;
  jacobian_.resize(count, t_.size());
  report.iterations = 0;
  while (objective_ > 0 && residual_.norm() > done) {
    report.status = FrameStatus::not_converged;
    if (report.iterations == options.max_iterations) break;
    if (report.iterations == 0) {
      for (Eigen::Index i = 0; i < count; ++i) {
        jacobian_.row(i) = background_jacobian_.row(kept[static_cast<std::size_t>(i)]);
      }
    } else {
      sheet_.jacobian(kept, jacobian_);
    }
    jacobian_.array().rowwise() *= slope_.transpose().array();
    linear_ = residual_;
    linear_.noalias() += jacobian_ * t_;
    if (!penalty_->minimise(jacobian_, linear_, z_, best_)) break;

    // Decrease that the linearised problem predicts. The quadratic above the total variation does
    // not overestimate it.
    penalty_->image(best_, t_trial_);
    linear_.noalias() -= jacobian_ * t_trial_;
    const double promised = objective_ - linear_.squaredNorm() / 2 - penalty_->value(best_);
    if (!(promised > least_decrease * objective_)) {
      report.status = std::isfinite(promised) ? FrameStatus::ok : FrameStatus::not_converged;
      break;
    }
    double length = 1;
    double reached = 0;
    ratio_before_ = ratio_;
    for (int i = 0;; ++i, length /= 2) {
      trial_ = z_ + length * (best_ - z_);
      reached = set(trial_, kept);
      if (reached <= objective_ - sufficient * length * promised || i == halvings) break;
    }
    if (!(reached < objective_)) break;  // rounding: no step is any better
    ++report.iterations;
    const double before = objective_;
    objective_ = reached;
    std::swap(z_, trial_);
    std::swap(t_, t_trial_);
    // Change of a full step in conductivities, since t may grow without limit near a bound.
    const double change_of_image = (ratio_ - ratio_before_).norm() / length;
    if (change_of_image <= options.tolerance * (ratio_.array() - 1).matrix().norm()) {
      report.status = FrameStatus::ok;
      break;
    }
    if (before - reached < least_decrease * before) {
      report.status = FrameStatus::ok;
      break;
    }
    if (residual_.norm() <= done) report.status = FrameStatus::ok;
  }
  bounds_.ratios(t_, ratio_, slope_);
  image = background_ * (ratio_.array() - 1).matrix().transpose();
  if (!image.allFinite()) {
    image.setZero();
    report.status = FrameStatus::undefined;
  }
}

GaussNewton::GaussNewton(JsonObject parameters) { read(std::move(parameters)); }

void GaussNewton::read(JsonObject parameters) {
  prior_ = parameters.choice_or("prior", name_of(Prior::noser),
                                {"tikhonov", "noser", "laplace", total_variation, training});
  lambda_ = read_weight(parameters, "lambda");
  options_.tolerance = parameters.number_or("tolerance", 1e-2, {1e-10, 0.5});
  options_.max_iterations = parameters.integer_or("max_iterations", 20, 1, 1000);
  options_.discrepancy = parameters.number_or("discrepancy", 0, {0, 1e3});
  if (parameters.has("bounds")) {
    const std::vector<double> bounds = parameters.numbers("bounds", 2, {0, 1e6});
    low_ = bounds[0];
    high_ = bounds[1];
    if (!(low_ < 1 && high_ > 1)) {
      parameters.fail("bounds", "must lie to both sides of 1, the background");
    }
  }
  calibrate_ = parameters.boolean_or("calibrate", false);
  read_chosen(parameters, lambda_);
  mask_ = ChannelMask::from_json(parameters);
  parameters.finish();
}

nlohmann::json GaussNewton::parameters() const {
  nlohmann::json out = {{"prior", prior_},
                        {"bounds", {low_, high_}},
                        {"tolerance", options_.tolerance},
                        {"max_iterations", options_.max_iterations},
                        {"discrepancy", options_.discrepancy},
                        {"calibrate", calibrate_}};
  lambda_.add_to(out, "lambda");
  mask_.add_to(out);
  return out;
}

void GaussNewton::check(const Sensor& sensor) const {
  mask_.check(sensor);
  const ForwardModel model(sensor,
                           sensor.image_grid);  // throws if the grid does not fit the sensor
}

void GaussNewton::set_sensor(const Sensor& sensor) {
  const ForwardModel model(sensor, sensor.image_grid);
  sensor_ = sensor;
  bounds_ = BoundedConductivity(sensor.background, low_, high_);
  background_jacobian_ = sensor.background * Reciprocity(sensor).reduce_rows(model.jacobian());
  gains_ = Eigen::VectorXd::Ones(sensor.channels());
  idle_.clear();
}

void GaussNewton::set_shaping(const FitInput& input) {
  shaping_.resize(0, 0);
  if (prior_ == training) {
    if (!input.training) {
      throw InputError(std::string(type) +
                       ": the prior \"training\" needs a training set; add \"train\" to the "
                       "datasets");
    }
    if (input.training->sensor() != sensor_) {
      throw InputError(std::string(type) + ": the training set " + input.training->path().string() +
                       " is of another sensor; generate it for this one");
    }
    shaping_ = shaping_of(*input.training, bounds_);
  } else if (prior_ == name_of(Prior::tikhonov) || prior_ == name_of(Prior::noser)) {
    const Eigen::MatrixXd jacobian = background_jacobian_ / sensor_.background;
    shaping_ = prior_factors(prior_from_name(prior_), jacobian, sensor_.image_columns())
                   .shaping.diagonal();
  }
}

void GaussNewton::set_gains(const FitInput& input) {
  if (!calibrate_) return;
  const DatasetFile* const set = input.validation ? input.validation : input.training;
  if (!set) {
    throw InputError(std::string(type) +
                     ": \"calibrate\" needs a validation set, whose reference voltages are those "
                     "of the sensor");
  }
  gains_ = ForwardModel(sensor_, sensor_.image_grid)
               .reference_voltages()
               .cwiseQuotient(set->reference_voltages());
  if (!gains_.allFinite()) {
    throw InputError(set->path().string() +
                     ": \"calibrate\" divides by its reference voltages, some of which are zero");
  }
}

void GaussNewton::fit(const FitInput& input) {
  set_sensor(input.sensor);
  set_shaping(input);
  set_gains(input);
  if (lambda_.automatic()) choose_lambda(input);
}

void GaussNewton::choose_lambda(const FitInput& input) {
  const ValidationFrames frames = read_validation_frames(input, lambda_.place);
  const Eigen::MatrixXd jacobian = background_jacobian_ / sensor_.background;
  double largest = 0;
  if (prior_ == total_variation) {
    // The weight at which a variation of |changes| / |J| weighs as much as the data.
    std::vector<double> sizes;
    for (Eigen::Index f = 0; f < frames.changes.rows(); ++f) {
      sizes.push_back(frames.changes.row(f).norm());
    }
    largest =
        1e-2 * upper_median(sizes) * dense_svd(jacobian).values[0] / sensor_.image().pixel().x();
  } else if (shaping_.cols() == 1) {
    largest = dense_svd(jacobian * shaping_.col(0).asDiagonal()).values[0];
  } else if (shaping_.cols() > 1) {
    largest = dense_svd(jacobian * shaping_).values[0];
  } else {
    largest = dense_svd(jacobian).values[0];
  }
  lambda_.choose(*this, frames, input.threads, {1e-4 * largest, largest}, 2, [&](double lambda) {
    lambda_.value = lambda;
    idle_.clear();
  });
  idle_.clear();
}

std::unique_ptr<Penalty> GaussNewton::penalty() const {
  const double lambda = *lambda_.value;
  if (shaping_.size() > 0) return std::make_unique<ShapedPenalty>(shaping_, lambda);
  if (prior_ == total_variation) {
    return std::make_unique<EdgePenalty>(sensor_.image_columns(), sensor_.image_rows(),
                                         lambda * sensor_.image().pixel().x(),
                                         smoothing * sensor_.background);
  }
  return std::make_unique<EdgePenalty>(sensor_.image_columns(), sensor_.image_rows(),
                                       lambda * lambda, 0);
}

void GaussNewton::reconstruct(FramesView changes, ImagesView images,
                              std::span<FrameReport> reports) const {
  std::unique_ptr<GaussNewtonIteration> iteration;
  {
    const std::lock_guard lock(idle_mutex_);
    if (!idle_.empty()) {
      iteration = std::move(idle_.back());
      idle_.pop_back();
    }
  }
  if (!iteration) {
    iteration =
        std::make_unique<GaussNewtonIteration>(sensor_, bounds_, penalty(), background_jacobian_);
  }
  std::vector<Eigen::Index> kept = pairs_without(sensor_, mask_.electrodes);
  ElectrodeSet without = 0;
  Eigen::RowVectorXd calibrated(changes.cols());
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    FrameReport& report = reports[static_cast<std::size_t>(f)];
    if (report.dead != without) {
      without = report.dead;
      kept = pairs_without(sensor_, mask_.electrodes | without);
    }
    if (kept.empty()) {
      images.row(f).setZero();
      continue;
    }
    calibrated = changes.row(f).cwiseProduct(gains_.transpose());
    iteration->minimise(calibrated, kept, options_, images.row(f), report);
  }
  const std::lock_guard lock(idle_mutex_);
  idle_.push_back(std::move(iteration));
}

void GaussNewton::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor_, parameters());
  out.write_vector("/gains", gains_);
  if (shaping_.size() > 0) out.write_matrix("/shaping", shaping_);
  out.close();
}

void GaussNewton::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type, sensor);
  read(JsonObject(parameters_of_fit(opened), file.string(), "/parameters"));
  lambda_.require_chosen();
  const auto pixels = static_cast<std::uint64_t>(sensor.pixels());
  opened.require_shape("/gains", {static_cast<std::uint64_t>(sensor.channels())});
  Eigen::MatrixXd shaping;
  const bool shaped =
      prior_ == training || prior_ == name_of(Prior::tikhonov) || prior_ == name_of(Prior::noser);
  if (shaped) {
    opened.require_shape("/shaping", {pixels, 0});
    shaping = opened.read_rows("/shaping", 0, pixels);
  }
  set_sensor(sensor);
  gains_ = opened.read_vector("/gains");
  shaping_ = std::move(shaping);
}

std::vector<SolverType> iterated_solvers() {
  SolverInfo info;
  info.summary =
      "iterated Gauss-Newton on the grid model, min 1/2 |F(t) - dv|^2 + penalty, bounded "
      "conductivity";
  info.parameters = {
      {"prior",
       "the penalty: \"tikhonov\", \"noser\", \"laplace\" as one-step-gn has them, "
       "\"total-variation\" (smoothed at .01 of the background), \"training\" (Gaussian, of the "
       "training images' covariance); default \"noser\""},
      {"lambda",
       "weight of the penalty, > 0 or \"auto\"; default \"auto\"; its unit depends on the prior: V "
       "per S/m for tikhonov and laplace, V^2 per (S/m x domain unit) for total-variation, V for "
       "training"},
      {"bounds",
       "[low, high] of the conductivity beside the background, 0 <= low < 1 < high; default [0, "
       "2]"},
      {"tolerance",
       "relative change of the image at which a frame is done, 1e-10 ... 0.5; default 1e-2"},
      {"max_iterations",
       "after which a frame is given up as not converged, 1 ... 1000; default 20"},
      {"discrepancy",
       "done as soon as the misfit is this many times the frame's noise, as reciprocal channels "
       "show it; default 0: it does not end an iteration"},
      {"calibrate",
       "multiply each channel with the ratio of the grid model's reference voltage to the "
       "validation set's, which undoes a part of the grid's error; default false"},
      ChannelMask::parameter()};
  info.make = make_from_json<GaussNewton>;
  info.probes = {R"({"prior": "noser", "lambda": 1e-3})",
                 R"({"prior": "total-variation", "lambda": 1e-6})",
                 R"({"prior": "training", "lambda": 1e-3})"};
  return {{GaussNewton::type, info}};
}

}  // namespace ertbench
