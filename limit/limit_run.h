#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "limit/frame_limit.h"
#include "limit/posterior_sampler.h"

namespace ertbench {

struct LimitOptions {
  std::vector<std::string> datasets;  ///< test sets; none: all
  int frames = 100;                   ///< of each set, the first
  int threads = 1;
  SamplerKind sampler = SamplerKind::automatic;
  bool fair = true;  ///< also under the training set's distribution, which may take far longer
  std::filesystem::path
      records;  ///< folder of the frames' records, which a later call goes on from
};

/// The limits of a set's frames under one prior: "oracle", the distribution of its own scenes, or
/// "fair", that of the training set.
struct SetLimit {
  std::string dataset;
  std::string prior;
  std::string model;  ///< of the likelihood: SceneVoltages::name
  std::string key;    ///< limit_key() of the set
  std::vector<FrameLimit> frames;
};

/// Computes what is missing, writes each frame's record when it is finished (into another file,
/// renamed), and reads the others. Progress goes to standard error. Throws InputError for sets that
/// have no limit: touches, sequences, lists of scenes, faults, no noise.
std::vector<SetLimit> compute_limits(const Experiment& experiment, const LimitOptions& options);

/// Why a set has no limit; empty where it has.
std::string why_no_limit(const DatasetSpec& spec);

/// The frames of a set as a reference row of the results, "limit-oracle" or "limit-fair": each
/// metric that has a limit, of all frames, unresolved ones among them. Among its parameters are
/// `"calibration": {"squared_error_over_variance", "ci95"}` and the frames that are `"unresolved"`.
ResultRow row_of(const SetLimit& limit);

/// Whether the posteriors deserve belief.
struct LimitCalibration {
  /// Mean of |truth - posterior mean|^2 over the mean of the posterior's variance: 1 where the
  /// posterior is right. With its 95 % bootstrap interval over the frames.
  double squared_error_over_variance = 0;
  Interval ci95;
  /// By limit_ranks: the p value of a chi square test of the ranks against their uniform
  /// distribution, in ten bins. Nothing for fewer than twenty frames, and where nothing
  /// is_ranked().
  std::array<std::optional<double>, limit_ranks.size()> p_values;
};
LimitCalibration calibration_of(std::span<const FrameLimit> frames);

/// Whether the ranks of that one of limit_ranks say anything: not where two of them are the same in
/// all frames, since their truths tie with all samples (the sum and the number of contacts, of
/// scenes with one disc of one size) and what shares out ties is all that is left.
bool is_ranked(std::span<const FrameLimit> frames, std::size_t rank);

/// `{"schema": 1, "experiment", "build", "rows": [rows of results], "sets": [{"dataset", "prior",
/// "model", "sampler", "frames", "unresolved": [numbers], "resolved": {metric: summary of the
/// resolved frames}, "expected": {metric: the posterior's own mean error},
/// "all_frames": {metric: summary}, "relative_error_of_mean", "sphere": {"width", "relative_error",
/// "without": that of the same frames without it}, "calibration", "per_frame": [...]}]}`
nlohmann::json limit_json(const std::string& experiment, std::span<const SetLimit> limits);

/// The rows that `options` ask for, of the file in a folder of results, where the file has all of
/// them: of this code, these sets and as many frames. None where one is missing, and where the
/// options name a sampler, which the file's may not be of. Throws as read_limit_rows() does.
std::vector<ResultRow> finished_limits(const std::filesystem::path& folder,
                                       const Experiment& experiment, const LimitOptions& options);

/// `now` with what `before`, of an earlier call, says of other sets and priors. Throws
/// nlohmann::json::exception where that is no such JSON.
nlohmann::json with_others(nlohmann::json now, const nlohmann::json& before);

}  // namespace ertbench
