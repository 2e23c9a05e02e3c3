#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "core/probe.h"
#include "forward/sheet/sensor.h"
#include "limit/frame_limit.h"
#include "limit/posterior_sampler.h"

namespace ertbench {

struct LimitOptions {
  std::vector<std::string> datasets;  ///< test sets; empty: all
  int frames = 100;                   ///< number of first frames of each set
  int threads = 1;
  SamplerKind sampler = SamplerKind::automatic;
  bool fair = true;    ///< also under the training set's distribution, which may take far longer
  bool lower = false;  ///< in place of both: lower_bound_of_frame()
  std::filesystem::path
      records;  ///< folder of the frames' records, from which a later call resumes
};

/// Limits of a set's frames under one prior: "oracle", the distribution of its own scenes, or
/// "fair", that of the training set; or "lower", the lower bound under the former.
struct SetLimit {
  std::string dataset;
  std::string prior;
  std::string model;  ///< model_name() of the likelihood
  std::string key;    ///< limit_key() of the set
  std::vector<FrameLimit> frames;
};

/// The sets that `options` name and that have a limit; the others are warned of. Throws InputError
/// if none has one: touches, sequences, lists of scenes, faults and sets without noise have none.
std::vector<const DatasetSpec*> sets_with_limit(const Experiment& experiment,
                                                const LimitOptions& options);

/// Computes the missing frames, writing each one's record by atomic rename, and reads the others.
/// Progress goes to standard error. Throws as sets_with_limit() does.
std::vector<SetLimit> compute_limits(const Experiment& experiment, const LimitOptions& options);

/// Why a set has no limit; empty if it has one.
std::string why_no_limit(const DatasetSpec& spec);

/// The reference row of a set in results, "limit-oracle" or "limit-fair": each metric that has a
/// limit, over all frames including unresolved ones. Its parameters have `"calibration":
/// {"squared_error_over_variance", "ci95"}` and the numbers of the `"unresolved"` frames; those of
/// "limit-lower" `"squared_error": {"over_empty", "ci95"}`, the least mean squared error over that
/// of an empty image.
ResultRow row_of(const SetLimit& limit);

/// Tests of whether the posteriors are right.
struct LimitCalibration {
  /// Mean of |truth - posterior mean|^2 over the mean of the posterior's variance, which is 1 if
  /// the posterior is right, with its 95 % bootstrap interval over the frames.
  double squared_error_over_variance = 0;
  Interval ci95;
  /// [limit_ranks] p value of a chi square test of the ranks against their uniform distribution in
  /// ten bins. Nothing for fewer than twenty frames and for ranks that are not is_ranked().
  std::array<std::optional<double>, limit_ranks.size()> p_values;
};
LimitCalibration calibration_of(std::span<const FrameLimit> frames);

inline constexpr int rank_bins = 10;
/// Frames by the rank of the truth by that one of limit_ranks, in bins of equal width.
std::array<double, rank_bins> rank_counts(std::span<const FrameLimit> frames, std::size_t rank);

/// True if the ranks by that one of limit_ranks carry information. They do not if two of them agree
/// in all frames: the truth then ties with all samples, as the sum and the number of contacts do
/// for scenes of one disc of one size.
bool is_ranked(std::span<const FrameLimit> frames, std::size_t rank);

/// `{"schema": 1, "experiment", "build", "rows": [rows of results], "sets": [{"dataset", "prior",
/// "model", "sampler", "frames", "unresolved": [numbers], "resolved": {metric: summary of the
/// resolved frames}, "expected": {metric: the posterior's own mean error}, "all_frames": {metric:
/// summary}, "relative_error_of_mean", "sphere": {"width", "relative_error", "without": the
/// relative error of the same frames off the sphere}, "calibration", "per_frame": [...]}]}`
nlohmann::json limit_json(const std::string& experiment, std::span<const SetLimit> limits);

/// Reads the rows that `options` ask for from a folder of results. Returns none unless the file has
/// all of them, for these sets, as many frames and the present code, or if the options name a
/// sampler. Throws as read_limit_rows() does.
std::vector<ResultRow> finished_limits(const std::filesystem::path& folder,
                                       const Experiment& experiment, const LimitOptions& options);

/// Adds the other sets and priors of `before`, the file of an earlier call, to `now`. Throws
/// nlohmann::json::exception if `before` is no such JSON.
nlohmann::json with_others(nlohmann::json now, const nlohmann::json& before);

/// The probe "limit": the best estimates of frames of one disc, by each of the samplers, with few
/// samples.
Probe limit_probe();

/// Draws histograms of the truths' ranks among the samples of their posteriors (Talts et al. 2018),
/// which are flat if the posteriors are right. Rows are sets under the prior of their own scenes,
/// columns are limit_ranks. Writes `stem`.svg and `stem`.png. Throws InputError if gnuplot is
/// missing or a file cannot be written.
void draw_rank_figure(std::span<const SetLimit> limits, const std::string& title,
                      const std::filesystem::path& stem);

/// The Cramér-Rao bound of one disc of unknown position, size and conductivity, for each position
/// on the sheet: the smallest standard deviations of unbiased estimates from one frame.
struct BoundMap {
  Sensor sensor;  ///< the pixels of its image are the positions
  /// [pixels] rms distance from the true centre and standard deviation of the radius, mm, at 50 dB
  /// (absolute); not finite where the disc does not fit on the sheet. Both are proportional to the
  /// noise.
  Eigen::RowVectorXd place_mm, radius_mm;
};

/// Computes the bound of a disc of `radius` (domain units) and `ratio` by BorderModel::linearise.
BoundMap bound_map(const Sensor& sensor, double radius, double ratio);

inline constexpr double bound_map_db = 50;

/// Draws the maps side by side, one for each number of electrodes, and the bound against the
/// signal-to-noise ratio, into `stem`.svg and `stem`.png. Throws InputError if gnuplot is missing
/// or a file cannot be written.
void draw_bound_maps(const std::vector<BoundMap>& maps, const std::string& title,
                     const std::filesystem::path& stem);

}  // namespace ertbench
