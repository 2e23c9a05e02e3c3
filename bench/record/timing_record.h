#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/experiment/fit_recipe.h"
#include "bench/record/result_row.h"
#include "bench/record/timing_place.h"

namespace ertbench {

/// What the clock said on one test set.
struct MeasuredTimes {
  LatencySummary latency_us;
  double frames_per_s = 0;  ///< median of the rounds
  int batch = 0;            ///< frames in a call where the throughput was measured
};

/// Of each round `{"schema", "key", "timing": {dataset: {"latency_us": [every frame],
/// "frames_per_s", "batch", "pipe_us": [every frame through Solver::transport, if any]}},
/// "calibration_us", "peak_rss_mb", "place"}`, put together.
struct TimingRecord {
  std::map<std::string, MeasuredTimes> sets;  ///< by test set
  double calibration_us = 0;                  ///< median of the rounds
  double peak_rss_mb = 0;                     ///< largest of the rounds
  TimingPlace place;                          ///< the first round's, with the busiest load
};

/// The latency of one round in units of what calibration_us() took just before it, in the same
/// process: whatever clock rate the processor had then, both had. Of frames under a millisecond the
/// median counts; a longer one is seldom left alone on a busy machine, and the fastest counts.
double relative_latency(double median_us, double fastest_us, double calibration_us);

/// What determines the record of a round, whichever it is: the solver, the test sets, how the clock
/// is used. The processor is no part of it; it stands in the record.
std::string timing_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                       const TimingSettings& timing);

/// Where a round was measured. Throws an exception of any kind where it does not say.
TimingPlace timing_place_of(const nlohmann::json& round);
nlohmann::json to_json(const TimingPlace& place);

/// Puts all rounds together, one at least. Throws an exception of any kind where one is not such a
/// record.
TimingRecord timing_record_from_json(const std::vector<nlohmann::json>& rounds);

}  // namespace ertbench
