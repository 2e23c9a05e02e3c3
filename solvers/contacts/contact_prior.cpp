#include "solvers/contacts/contact_prior.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/ellipses/ellipse_model.h"
#include "solvers/channel_mask.h"

namespace ertbench {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;

/// Scenes of the training set that are used; enough for five numbers.
constexpr std::uint64_t prior_scenes = 4000;
/// Least deviation learned from a training set, so that a prior from uniform contacts serves on
/// other sets.
constexpr double least_deviation = 0.1;

double deviation(double sum, double squares, double count) {
  return std::max(least_deviation,
                  std::sqrt(std::max(0.0, squares / count - std::pow(sum / count, 2))));
}

}  // namespace

ContactPrior ContactPrior::of(const DatasetFile& training) {
  double count = 0;
  ContactPrior prior;
  prior.may_fall = prior.may_rise = false;
  Eigen::Vector3d sums = Eigen::Vector3d::Zero();
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Scene& scene : training.scenes(0, std::min(training.size(), prior_scenes))) {
    for (const Contact& contact : scene.contacts) {
      const EllipticContact ellipse = nearest_ellipse(contact);
      const Eigen::Vector3d values(ellipse.log_size, ellipse.stretch.norm(),
                                   std::abs(ellipse.log_ratio));
      (contact.conductivity_ratio < 1 ? prior.may_fall : prior.may_rise) = true;
      sums += values;
      squares += values.cwiseAbs2();
      ++count;
    }
  }
  if (count == 0) {
    throw InputError(
        training.path().string() +
        ": no scene holds a contact that a prior could be learnt from; give \"prior\": \"broad\"");
  }
  prior.log_size_mean = sums[0] / count;
  prior.log_size_deviation = deviation(sums[0], squares[0], count);
  prior.stretch_deviation = std::max(least_deviation, std::sqrt(squares[1] / count / 2));
  prior.log_ratio_mean = sums[2] / count;
  prior.log_ratio_deviation = deviation(sums[2], squares[2], count);
  return prior;
}

double ContactPrior::add_to(const EllipticContact& contact, double weight,
                            Eigen::Ref<EllipticContact::Vector> gradient,
                            Eigen::Ref<EllipticContact::Vector> curvature) const {
  const double ratio_mean = contact.log_ratio < 0 ? -log_ratio_mean : log_ratio_mean;
  const Eigen::Vector4d from_mean(contact.log_size - log_size_mean, contact.stretch.x(),
                                  contact.stretch.y(), contact.log_ratio - ratio_mean);
  const Eigen::Vector4d inverse = weight * Eigen::Vector4d(log_size_deviation, stretch_deviation,
                                                           stretch_deviation, log_ratio_deviation)
                                               .cwiseAbs2()
                                               .cwiseInverse();
  gradient.tail<4>() += inverse.cwiseProduct(from_mean);
  curvature.tail<4>() += inverse;
  return from_mean.cwiseAbs2().dot(inverse) / 2;
}

double ContactPrior::log_constant(double weight, double sheet_area) const {
  const auto gaussian = [&](double deviation) {
    return std::log(weight / (2 * pi)) / 2 - std::log(deviation);
  };
  return -std::log(sheet_area) + gaussian(log_size_deviation) + gaussian(log_ratio_deviation) -
         (may_fall && may_rise ? std::numbers::ln2 : 0) +  // half of it for either sign
         2 * gaussian(stretch_deviation);
}

nlohmann::json to_json(const ContactPrior& prior) {
  return {{"log_size", {prior.log_size_mean, prior.log_size_deviation}},
          {"stretch", prior.stretch_deviation},
          {"log_ratio", {prior.log_ratio_mean, prior.log_ratio_deviation}},
          {"falls", prior.may_fall},
          {"rises", prior.may_rise}};
}

ContactPrior contact_prior_from_json(JsonObject object) {
  ContactPrior prior;
  const auto pair = [&](const char* key, double& mean, double& deviation) {
    const std::vector<double> both = object.numbers(key, 2);
    mean = both[0];
    deviation = both[1];
    if (deviation <= 0) object.fail(key, "must be [mean, deviation] with a deviation > 0");
  };
  pair("log_size", prior.log_size_mean, prior.log_size_deviation);
  prior.stretch_deviation = object.number("stretch", Range::positive());
  pair("log_ratio", prior.log_ratio_mean, prior.log_ratio_deviation);
  prior.may_fall = object.boolean_or("falls", true);
  prior.may_rise = object.boolean_or("rises", true);
  object.finish();
  return prior;
}

MatrixXd whitening_of(const Sensor& sensor, double noise, const Nuisances& nuisances) {
  const Reciprocity reciprocity(sensor);
  VectorXd over_mean(reciprocity.pairs());  // d' over the mean of a pair's channels
  for (Index p = 0; p < over_mean.size(); ++p) over_mean[p] = reciprocity.of_mean(p);
  const VectorXd precision = over_mean / noise;
  if (!nuisances.any()) return precision.asDiagonal();
  const MatrixXd columns = over_mean.cwiseInverse().asDiagonal() * nuisances.columns(sensor);
  MatrixXd covariance = columns * columns.transpose();
  covariance.diagonal() += precision.cwiseAbs2().cwiseInverse();
  const Eigen::LLT<MatrixXd> factor(covariance);
  return factor.matrixL().solve(MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

}  // namespace ertbench
