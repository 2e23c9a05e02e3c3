#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "core/build_stamp.h"
#include "forward/sheet/sensor.h"
#include "limit/annealed_sampler.h"

namespace ertbench {

/// Vectors drawn from a posterior, images or positions.
struct WeightedSamples {
  RowMajorMatrix values;     ///< [samples, length]
  Eigen::VectorXd weights;   ///< [samples] >= 0, with a sum above 0
  std::vector<int> islands;  ///< [samples] the sampler that each came from, 0 ...
};

/// The posterior mean [length], which minimises the mean squared distance.
Eigen::RowVectorXd posterior_mean(const WeightedSamples& samples);

/// The point [length] that minimises the mean of scale * distance, `scales` [samples], by
/// Weiszfeld's iteratively reweighted means from the posterior mean.
Eigen::RowVectorXd weighted_median_point(const WeightedSamples& samples,
                                         const Eigen::VectorXd& scales);

/// The posterior mean of scale * |value - estimate|.
double expected_distance(const WeightedSamples& samples, const Eigen::VectorXd& scales,
                         const Eigen::RowVectorXd& estimate);

/// Sum of the variances of all entries.
double total_variance(const WeightedSamples& samples);

/// Half the mean squared distance between the last samples of any two islands, at least two.
double variance_between_last(const WeightedSamples& samples);

/// Effective number of independent samples: the samples' variance over the variance of their mean.
/// With several islands, which are independent, the mean's variance follows from the spread of
/// their means; with one, the samples are independent and their weights give Kish's number.
double effective_samples(const WeightedSamples& samples);

/// Rank of `truth` among the samples, 0 ... 1, with ties broken by `uniform`. Over scenes drawn
/// from the prior the rank is uniform if the posterior is right (Talts et al. 2018).
double weighted_rank(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const Eigen::VectorXd& weights, double truth, double uniform);

/// The metrics that have a limit. Each has its own best estimate, which minimises its mean.
inline constexpr std::array<const char*, 3> limit_metrics = {"relative_error", "RIE", "PE"};

/// Quantities whose ranks of the truth among the samples test the calibration.
inline constexpr std::array<const char*, 5> limit_ranks = {"sum", "x", "y", "norm", "contacts"};

/// Errors of the best estimates for one frame under one prior.
struct FrameLimit {
  std::uint64_t frame = 0;
  std::string sampler;  ///< "enumeration", "importance", "annealing"
  int samples = 0;
  double effective = 0;   ///< effective_samples()
  double quantities = 0;  ///< mean number of unknowns of the posterior's scenes, six per contact
  bool resolved = false;
  std::string remark;  ///< why it is unresolved
  double pareto_k = 0;
  bool alone = false;       ///< of PosteriorSamples
  bool one_origin = false;  ///< of PosteriorSamples
  double seconds = 0;
  std::uint64_t solves = 0;

  /// Error of the best estimate against the truth, and the posterior's expectation of it; nothing
  /// if the metric is undefined.
  struct Value {
    std::optional<double> error;
    std::optional<double> expected;
  };
  std::map<std::string, Value> metrics;  ///< by limit_metrics
  double relative_error_of_mean = 0;     ///< the posterior mean's; 0 if the truth has no contact
  double squared_error = 0;              ///< the posterior mean's, (S/m)^2
  double variance = 0;                   ///< the posterior's, (S/m)^2
  double energy = 0;                     ///< |truth|^2, the squared error of an empty image
  std::array<double, limit_ranks.size()> ranks{};
  double chi_square = 0;  ///< posterior mean
  /// Relative error of the best estimate, and effective samples, with the noise on the sphere
  /// (sphere_weights).
  std::optional<double> sphere_relative_error;
  double sphere_effective = 0;
  BuildStamp build;  ///< the build that computed it; kept in the record, not in the JSON below
};

/// Width in chi square of the shell around the sphere, for models in error by 1 % of the noise.
inline constexpr double sphere_width = 2;

struct FrameTruth {
  Scene scene;
  Eigen::RowVectorXd conductivity;  ///< [pixels] S/m
};

/// Fills in all but sampler, Pareto k, seconds and solves, and does not judge. `uniform` 0 ... 1
/// breaks ties of ranks.
FrameLimit limit_of_frame(const Sensor& sensor, Rasterisation rule, const FrameTruth& truth,
                          const PosteriorSamples& posterior, double uniform);

/// A lower bound of what the best estimates can have in the mean over frames, from chains that were
/// started at scenes drawn from the posterior (AnnealingIsland::run_chains). For samples x_1 ...
/// x_K that each have the posterior's distribution, whatever their dependence, the expected error
/// of any estimate is that of (1/K) sum_i w_i |estimate - x_i|, which is at least the mean of the
/// least value of this sum. That is each metric's `error` and `expected`. `variance` is
/// variance_between_last() of the images: the covariance of two chains that are independent given
/// their common start is not negative, so that its mean is at most that of the posterior variance.
/// `truth` must have a contact.
FrameLimit lower_bound_of_frame(const Sensor& sensor, Rasterisation rule, const FrameTruth& truth,
                                const PosteriorSamples& chains);

/// Sets `resolved` and `remark`. A resolved frame has enough effective samples, importance weights
/// without a heavy tail, samples that descend from more than one island, and scenes that explain
/// the frame: a chi square at most three standard deviations above the number of channels, with the
/// standard deviation for as many quantities as the scenes have.
void judge(int channels, FrameLimit& limit);
/// True if more work may resolve the frame: it has fewer than twenty effective samples, or is
/// unresolved for a reason other than few samples or a single origin.
bool deserves_more(int channels, const FrameLimit& limit);

nlohmann::json to_json(const FrameLimit& limit);
FrameLimit frame_limit_from_json(JsonObject object);

}  // namespace ertbench
