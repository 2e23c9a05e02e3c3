#include "solvers/iterated/gauss_newton.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "core/quantile.h"
#include "forward/data/dataset_file.h"
#include "forward/fem/forward_model.h"
#include "solvers/dense_svd.h"
#include "solvers/linear/prior.h"
#include "solvers/solver_file.h"
#include "solvers/symmetric_eigen.h"

namespace ertbench {
namespace {

/// Differences beyond this part of the background count by their size in the total variation.
constexpr double smoothing = 0.01;
/// Directions of the training images that are kept: the others hold less than this part of what the
/// strongest does.
constexpr double least_variance = 1e-4;

/// E with E E^T = E[t t^T] over the training images, but for its weakest directions.
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
  choice_ = read_chosen(parameters, lambda_.value);
  mask_ = ChannelMask::from_json(parameters);
  parameters.finish();
}

nlohmann::json GaussNewton::parameters() const {
  nlohmann::json out = {{"prior", prior_},
                        {"lambda", "auto"},
                        {"bounds", {low_, high_}},
                        {"tolerance", options_.tolerance},
                        {"max_iterations", options_.max_iterations},
                        {"discrepancy", options_.discrepancy},
                        {"calibrate", calibrate_}};
  if (lambda_.value) out["lambda"] = *lambda_.value;
  mask_.add_to(out);
  if (choice_) out["chosen"] = to_json(*choice_);
  return out;
}

void GaussNewton::check(const Sensor& sensor) const {
  mask_.check(sensor);
  const ForwardModel model(sensor, sensor.image_grid);  // refuses what the grid does not serve
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
  const auto error_of = [&](double lambda) {
    lambda_.value = lambda;
    idle_.clear();
    return mean_relative_error(*this, frames, input.threads);
  };
  const Eigen::MatrixXd jacobian = background_jacobian_ / sensor_.background;
  double largest = 0;
  int per_decade = 2;
  if (prior_ == total_variation) {
    // The weight beside which a variation of |changes| / |J| counts like the data.
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
  choice_ = choose_number(lambda_.place, 1e-4 * largest, largest, per_decade,
                          static_cast<int>(frames.changes.rows()), error_of);
  lambda_.value = choice_->value;
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
  const nlohmann::json parameters = parameters_of_fit(opened);
  read(JsonObject(parameters, file.string(), "/parameters"));
  if (lambda_.automatic())
    throw InputError(file.string() + ": has no lambda; fit the solver again");
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

}  // namespace ertbench
