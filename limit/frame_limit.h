#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "core/build_stamp.h"
#include "forward/sheet/sensor.h"
#include "limit/annealed_sampler.h"

namespace ertbench {

/// Vectors drawn from a posterior, images or places.
struct WeightedSamples {
  RowMajorMatrix values;     ///< [samples, length]
  Eigen::VectorXd weights;   ///< [samples] >= 0, with a sum above 0
  std::vector<int> islands;  ///< [samples] of the sampler that each came from, 0 ...
};

/// Least mean of the squared distance: the posterior mean, [length].
Eigen::RowVectorXd posterior_mean(const WeightedSamples& samples);

/// Least mean of scale * distance, `scales` [samples]: by Weiszfeld's iteratively reweighted means,
/// from the posterior mean on. [length]
Eigen::RowVectorXd weighted_median_point(const WeightedSamples& samples,
                                         const Eigen::VectorXd& scales);

/// The posterior's mean of scale * |value - estimate|.
double expected_distance(const WeightedSamples& samples, const Eigen::VectorXd& scales,
                         const Eigen::RowVectorXd& estimate);

/// Sum of the variances of all entries.
double total_variance(const WeightedSamples& samples);

/// How many independent samples the posterior mean is worth: the samples' variance over that of the
/// mean. With several islands, which are independent, the mean's variance is told from how far
/// theirs are apart, whatever the cause; with one the samples are independent and their weights
/// tell (Kish).
double effective_samples(const WeightedSamples& samples);

/// Where `truth` stands among the samples, 0 ... 1, ties shared out by `uniform`: uniform over
/// scenes drawn from the prior where the posterior is right (Talts et al. 2018).
double weighted_rank(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::VectorXd& weights, double truth, double uniform);

class JsonObject;

/// The metrics that have a limit: each by the estimate that minimises its own mean.
inline constexpr std::array<const char*, 3> limit_metrics = {"relative_error", "RIE", "PE"};

/// What calibration looks at: ranks of the truth among the samples.
inline constexpr std::array<const char*, 5> limit_ranks = {"sum", "x", "y", "norm", "contacts"};

/// Effective samples under which a frame is listed as unresolved.
inline constexpr double least_effective = 100;

/// With as many, more work is not worth it: the squared error of a mean of k samples is 1/k above
/// the least.
inline constexpr double enough_effective = 20;

/// What the best estimates of one frame came to, under one prior.
struct FrameLimit {
  std::uint64_t frame = 0;
  std::string sampler;  ///< "enumeration", "importance", "annealing"
  int samples = 0;
  double effective = 0;   ///< independent samples that the posterior mean is worth
  double quantities = 0;  ///< of a scene of the posterior in the mean, six for each contact
  bool resolved = false;
  std::string remark;  ///< why it is not
  double pareto_k = 0;
  bool alone = false;       ///< of PosteriorSamples
  bool one_origin = false;  ///< of PosteriorSamples
  double seconds = 0;
  std::uint64_t solves = 0;

  /// Error of the best estimate against the truth, and the posterior's own mean of it; without a
  /// value where the metric is undefined.
  struct Value {
    std::optional<double> error;
    std::optional<double> expected;
  };
  std::map<std::string, Value> metrics;  ///< by limit_metrics
  double relative_error_of_mean = 0;     ///< of the posterior mean; 0 for a blank truth
  double squared_error = 0;              ///< of the posterior mean, (S/m)^2
  double variance = 0;                   ///< of the posterior, (S/m)^2
  std::array<double, limit_ranks.size()> ranks{};
  double chi_square = 0;  ///< the posterior's mean
  /// With the frame's noise on the sphere (sphere_weights): the relative error of its own best
  /// estimate, and the samples in force.
  std::optional<double> sphere_relative_error;
  double sphere_effective = 0;
  BuildStamp build;  ///< that computed it; stands in the record, not in the JSON below
};

/// Width of the sphere's shell in chi square: of models that are a hundredth of the noise off.
inline constexpr double sphere_width = 2;

/// A frame's truth and the samples that an estimate is made from.
struct FrameTruth {
  Scene scene;
  Eigen::RowVectorXd conductivity;  ///< [pixels] S/m
};

/// Fills in all but sampler, Pareto k, seconds and solves, and does not judge. `uniform` 0 ... 1
/// shares out ties of ranks.
FrameLimit limit_of_frame(const Sensor& sensor, Rasterisation rule, const FrameTruth& truth,
                          const PosteriorSamples& posterior, double uniform);

/// Whether a frame is resolved, and the remark: enough effective samples, importance weights
/// without a heavy tail, samples that descend from more than one island, and scenes that explain
/// the frame: a chi square at most three standard deviations above the number of channels, those of
/// as many quantities as the scenes have.
void judge(int channels, FrameLimit& limit);
/// Whether more work may tell more: where the frame is unresolved for another reason than that its
/// samples are fewer than least_effective, though not than enough_effective, or descend from one
/// island.
bool deserves_more(int channels, const FrameLimit& limit);

nlohmann::json to_json(const FrameLimit& limit);
FrameLimit frame_limit_from_json(JsonObject object);

}  // namespace ertbench
