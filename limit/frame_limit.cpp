#include "limit/frame_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "bench/score/image_contacts.h"
#include "bench/score/metric_formulas.h"
#include "core/fields.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr int most_weiszfeld_steps = 100;

Eigen::VectorXd distances(const WeightedSamples& samples, const Eigen::RowVectorXd& from) {
  return (samples.values.rowwise() - from).rowwise().norm();
}

/// Sum, centroid, norm and number of contacts, in the order of limit_ranks.
std::array<double, limit_ranks.size()> features(const Sensor& sensor, const RowVectorXd& change,
                                                std::size_t contacts) {
  const auto middle = centroid(sensor, change).value_or(Eigen::Vector2d::Zero());
  return {change.sum(), middle.x(), middle.y(), change.norm(), static_cast<double>(contacts)};
}

/// The samples as images.
struct SampledImages {
  WeightedSamples changes;  ///< S/m
  WeightedSamples places;   ///< true_centre of the samples that have one
  VectorXd inverse_norms;   ///< 1 / |change|; 0 without contact, where the error is undefined
  VectorXd inverse_sheets;  ///< 1 / |conductivity|
  RowMajorMatrix features;  ///< [samples, limit_ranks]
};

SampledImages images_of(const Sensor& sensor, Rasterisation rule,
                        const PosteriorSamples& posterior) {
  const auto count = static_cast<Eigen::Index>(posterior.samples.size());
  const PixelGrid pixels = sensor.image();
  SampledImages out;
  out.changes.values.resize(count, pixels.count());
  out.changes.weights.resize(count);
  out.inverse_norms.resize(count);
  out.inverse_sheets.resize(count);
  out.features.resize(count, static_cast<Eigen::Index>(limit_ranks.size()));
  std::vector<Eigen::Vector2d> places;
  std::vector<double> place_weights;
  VectorXd ratio(pixels.count());
  for (Eigen::Index i = 0; i < count; ++i) {
    const PosteriorSample& sample = posterior.samples[static_cast<std::size_t>(i)];
    const Scene scene = scene_of(sample.scene);
    rasterise(scene, pixels, rule, ratio);
    const RowVectorXd sheet = sensor.background * ratio.transpose();
    const RowVectorXd change = sheet.array() - sensor.background;
    out.changes.values.row(i) = change;
    out.changes.weights[i] = sample.weight;
    out.changes.islands.push_back(sample.island);
    out.inverse_norms[i] = is_empty(sensor, change) ? 0 : 1 / change.norm();
    out.inverse_sheets[i] = 1 / sheet.norm();
    const auto looked_at = features(sensor, change, sample.scene.size());
    for (std::size_t f = 0; f < looked_at.size(); ++f) {
      out.features(i, static_cast<Eigen::Index>(f)) = looked_at[f];
    }
    if (is_empty(sensor, change)) continue;
    if (const auto centre = true_centre(sensor, scene, change)) {
      places.push_back(*centre);
      place_weights.push_back(sample.weight);
    }
  }
  out.places.values.resize(static_cast<Eigen::Index>(places.size()), 2);
  for (std::size_t i = 0; i < places.size(); ++i) {
    out.places.values.row(static_cast<Eigen::Index>(i)) = places[i].transpose();
  }
  out.places.weights = Eigen::Map<const VectorXd>(place_weights.data(),
                                                  static_cast<Eigen::Index>(place_weights.size()));
  return out;
}

std::vector<double> chi_squares_of(const PosteriorSamples& posterior) {
  std::vector<double> out;
  for (const PosteriorSample& sample : posterior.samples) out.push_back(sample.fit.chi_square);
  return out;
}

/// Mean number of unknowns of a scene: position (2), size, ratio, aspect and angle per contact.
double mean_quantities(const PosteriorSamples& posterior) {
  constexpr double of_a_contact = 6;
  double sum = 0;
  double weights = 0;
  for (const PosteriorSample& sample : posterior.samples) {
    sum += sample.weight * of_a_contact * static_cast<double>(sample.scene.size());
    weights += sample.weight;
  }
  return weights > 0 ? sum / weights : 0;
}

constexpr std::pair<const char*, double FrameLimit::*> limit_numbers[] = {
    {"effective", &FrameLimit::effective},
    {"quantities", &FrameLimit::quantities},
    {"pareto_k", &FrameLimit::pareto_k},
    {"seconds", &FrameLimit::seconds},
    {"relative_error_of_mean", &FrameLimit::relative_error_of_mean},
    {"squared_error", &FrameLimit::squared_error},
    {"energy", &FrameLimit::energy},
    {"variance", &FrameLimit::variance},
    {"chi_square", &FrameLimit::chi_square},
    {"sphere_effective", &FrameLimit::sphere_effective}};

void visit(Fields& fields, FrameLimit::Value& value) {
  fields.required().nullable().number("error", value.error, {});
  fields.required().nullable().number("expected", value.expected, {});
}

void visit(Fields& fields, FrameLimit& limit) {
  constexpr int most = std::numeric_limits<int>::max();
  fields.required().integer("frame", limit.frame, 0, most);
  fields.required().words("sampler", limit.sampler);
  fields.required().integer("samples", limit.samples, 0, most);
  fields.boolean("resolved", limit.resolved);
  fields.words("remark", limit.remark);
  fields.boolean("alone", limit.alone);
  fields.boolean("one_origin", limit.one_origin);
  fields.required().integer("solves", limit.solves, 0, most);
  fields.required().object("metrics", [&](Fields& metrics) {
    for (const char* name : limit_metrics) {
      if (metrics.reading() ? !metrics.has(name) : !limit.metrics.contains(name)) continue;
      metrics.object(name, [&](Fields& both) { visit(both, limit.metrics[name]); });
    }
  });
  fields.required().object("ranks", [&](Fields& ranks) {
    for (std::size_t r = 0; r < limit_ranks.size(); ++r) {
      ranks.required().number(limit_ranks[r], limit.ranks[r], {});
    }
  });
  fields.required().nullable().number("sphere_relative_error", limit.sphere_relative_error, {});
  for (const auto& [key, member] : limit_numbers) {
    fields.required().number(key, limit.*member, {});
  }
}

/// Why a frame's posterior cannot be trusted, whatever the number of its samples; empty if it can.
std::string doubt(int channels, const FrameLimit& limit) {
  constexpr double most_deviations = 3;
  constexpr double most_pareto_k = 0.7;
  // The truth's chi square equals the number of channels, since the norm of the noise is fixed; the
  // posterior's chi square spreads around it with the number of free quantities.
  const double most_chi_square =
      channels + most_deviations * std::sqrt(2 * std::max(1.0, limit.quantities));
  if (limit.chi_square > most_chi_square) {
    return "the scenes that were found do not explain the frame: chi square " +
           fixed(limit.chi_square, 0) + " for " + std::to_string(channels) + " channels";
  }
  if (limit.alone) return "only one of its samplers found the scenes that explain it best";
  if (limit.pareto_k > most_pareto_k) {
    return "Pareto k " + fixed(limit.pareto_k, 2) + " > " + fixed(most_pareto_k, 1);
  }
  return "";
}

/// A frame with fewer effective samples is listed as unresolved.
constexpr double least_effective = 100;
/// Effective samples from which on more work is not worth it: the squared error of a mean of k
/// samples is 1/k above the minimum.
constexpr double enough_effective = 20;

bool has_fewer(const FrameLimit& limit, double samples) {
  return limit.sampler != "enumeration" && limit.effective < samples;
}

}  // namespace

Eigen::RowVectorXd posterior_mean(const WeightedSamples& samples) {
  return samples.weights.transpose() * samples.values / samples.weights.sum();
}

double expected_distance(const WeightedSamples& samples, const Eigen::VectorXd& scales,
                         const Eigen::RowVectorXd& estimate) {
  const Eigen::VectorXd apart = distances(samples, estimate);
  return (samples.weights.array() * scales.array() * apart.array()).sum() / samples.weights.sum();
}

Eigen::RowVectorXd weighted_median_point(const WeightedSamples& samples,
                                         const Eigen::VectorXd& scales) {
  Eigen::RowVectorXd estimate = posterior_mean(samples);
  double before = expected_distance(samples, scales, estimate);
  for (int step = 0; step < most_weiszfeld_steps; ++step) {
    const Eigen::VectorXd apart = distances(samples, estimate);
    // A sample at the estimate itself would otherwise get all the weight.
    const double least = 1e-6 * apart.maxCoeff() + 1e-300;
    const Eigen::VectorXd pull =
        samples.weights.array() * scales.array() / apart.array().max(least);
    const double sum = pull.sum();
    if (!(sum > 0) || !std::isfinite(sum)) return estimate;
    const Eigen::RowVectorXd next = pull.transpose() * samples.values / sum;
    const double after = expected_distance(samples, scales, next);
    if (!(after < before)) return estimate;
    estimate = next;
    if (before - after < 1e-7 * before) return estimate;
    before = after;
  }
  return estimate;
}

double total_variance(const WeightedSamples& samples) {
  const Eigen::VectorXd apart = distances(samples, posterior_mean(samples));
  return samples.weights.dot(apart.cwiseAbs2()) / samples.weights.sum();
}

double variance_between_last(const WeightedSamples& samples) {
  const auto islands = static_cast<Eigen::Index>(*std::ranges::max_element(samples.islands) + 1);
  RowMajorMatrix last(islands, samples.values.cols());
  for (Eigen::Index i = 0; i < samples.values.rows(); ++i) {
    last.row(samples.islands[static_cast<std::size_t>(i)]) = samples.values.row(i);
  }
  return (last.rowwise() - last.colwise().mean()).squaredNorm() / static_cast<double>(islands - 1);
}

double effective_samples(const WeightedSamples& samples) {
  const auto& weights = samples.weights;
  const double kish = weights.sum() * weights.sum() / weights.squaredNorm();
  const int islands = samples.islands.empty() ? 1 : *std::ranges::max_element(samples.islands) + 1;
  if (islands < 2) return kish;
  RowMajorMatrix means = RowMajorMatrix::Zero(islands, samples.values.cols());
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(islands);
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const int island = samples.islands[static_cast<std::size_t>(i)];
    means.row(island) += weights[i] * samples.values.row(i);
    sums[island] += weights[i];
  }
  if (sums.minCoeff() <= 0) return 1;
  means.array().colwise() /= sums.array();
  const Eigen::VectorXd shares = sums / sums.sum();
  const Eigen::RowVectorXd middle = shares.transpose() * means;
  const double of_mean =
      shares.cwiseAbs2().dot((means.rowwise() - middle).rowwise().squaredNorm()) * islands /
      (islands - 1.0);
  const double variance = total_variance(samples);
  return of_mean * kish > variance ? variance / of_mean : kish;
}

double weighted_rank(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::VectorXd& weights, double truth, double uniform) {
  const double tie = 1e-9 * (1 + std::abs(truth));
  double below = 0;
  double equal = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::abs(values[i] - truth) <= tie) {
      equal += weights[i];
    } else if (values[i] < truth) {
      below += weights[i];
    }
  }
  return (below + uniform * equal) / weights.sum();
}

FrameLimit limit_of_frame(const Sensor& sensor, Rasterisation rule, const FrameTruth& truth,
                          const PosteriorSamples& posterior, double uniform) {
  const SampledImages images = images_of(sensor, rule, posterior);
  const VectorXd& weights = images.changes.weights;
  FrameLimit limit;
  limit.samples = static_cast<int>(posterior.samples.size());
  limit.effective = effective_samples(images.changes);
  limit.quantities = mean_quantities(posterior);
  limit.alone = posterior.alone;
  limit.one_origin = posterior.one_origin;
  const RowVectorXd change = truth.conductivity.array() - sensor.background;
  const bool blank = is_empty(sensor, change);
  limit.energy = change.squaredNorm();
  const RowVectorXd mean = posterior_mean(images.changes);
  limit.squared_error = (mean - change).squaredNorm();
  limit.variance = total_variance(images.changes);
  if (!blank) limit.relative_error_of_mean = (mean - change).norm() / change.norm();

  // A scene without contact has no relative error and does not enter its mean.
  const auto relative = [&](WeightedSamples samples) {
    const VectorXd defined =
        (images.inverse_norms.array() > 0).select(samples.weights.array(), 0.0).matrix();
    if (defined.sum() > 0) samples.weights = defined;
    const RowVectorXd best = weighted_median_point(samples, images.inverse_norms);
    return FrameLimit::Value{(best - change).norm() / change.norm(),
                             expected_distance(samples, images.inverse_norms, best)};
  };
  if (!blank) limit.metrics["relative_error"] = relative(images.changes);
  const RowVectorXd best = weighted_median_point(images.changes, images.inverse_sheets);
  limit.metrics["RIE"] = {(best - change).norm() / truth.conductivity.norm(),
                          expected_distance(images.changes, images.inverse_sheets, best)};
  const auto centre = blank ? std::nullopt : true_centre(sensor, truth.scene, change);
  if (centre && images.places.values.rows() > 0 && images.places.weights.sum() > 0) {
    const VectorXd ones = VectorXd::Ones(images.places.weights.size());
    const RowVectorXd place = weighted_median_point(images.places, ones);
    limit.metrics["PE"] = {(place - centre->transpose()).norm(),
                           expected_distance(images.places, ones, place)};
  }

  const auto looked_at = features(sensor, change, truth.scene.contacts.size());
  for (std::size_t f = 0; f < looked_at.size(); ++f) {
    limit.ranks[f] = weighted_rank(images.features.col(static_cast<Eigen::Index>(f)), weights,
                                   looked_at[f], uniform);
  }
  const std::vector<double> chi = chi_squares_of(posterior);
  limit.chi_square =
      Eigen::Map<const VectorXd>(chi.data(), static_cast<Eigen::Index>(chi.size())).dot(weights) /
      weights.sum();

  WeightedSamples on_sphere = images.changes;
  on_sphere.weights.array() *= sphere_weights(chi, sensor.channels(), sphere_width).array();
  const double sum = on_sphere.weights.sum();
  if (sum > 0) {
    limit.sphere_effective = sum * sum / on_sphere.weights.squaredNorm();
    if (!blank) limit.sphere_relative_error = relative(on_sphere).error;
  }
  return limit;
}

FrameLimit lower_bound_of_frame(const Sensor& sensor, Rasterisation rule, const FrameTruth& truth,
                                const PosteriorSamples& chains) {
  FrameLimit limit = limit_of_frame(sensor, rule, truth, chains, 0.5);
  limit.variance = variance_between_last(images_of(sensor, rule, chains).changes);
  limit.metrics.erase("PE");  // undefined for some samples, which would bias its mean
  for (auto& [name, value] : limit.metrics) value.error = value.expected;
  limit.sampler = "chains from the truth";
  limit.resolved = true;
  return limit;
}

void judge(int channels, FrameLimit& limit) {
  limit.remark = doubt(channels, limit);
  if (limit.remark.empty() && has_fewer(limit, least_effective)) {
    limit.remark =
        "effective samples " + fixed(limit.effective, 0) + " < " + fixed(least_effective, 0);
  }
  if (limit.remark.empty() && limit.one_origin) {
    limit.remark = "all samples descend from one of its samplers";
  }
  limit.resolved = limit.remark.empty();
}

bool deserves_more(int channels, const FrameLimit& limit) {
  return !doubt(channels, limit).empty() || has_fewer(limit, enough_effective);
}

nlohmann::json to_json(const FrameLimit& limit) {
  FrameLimit copy = limit;
  return Fields::written([&](Fields& fields) { visit(fields, copy); });
}

FrameLimit frame_limit_from_json(JsonObject object) {
  FrameLimit limit;
  Fields::read(std::move(object), [&](Fields& fields) { visit(fields, limit); });
  return limit;
}

}  // namespace ertbench
