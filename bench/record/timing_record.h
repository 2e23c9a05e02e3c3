#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/experiment/fit_recipe.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// What the clock said on one test set.
struct MeasuredTimes {
  LatencySummary latency_us;
  double frames_per_s = 0;  ///< median of the rounds
  int batch = 0;            ///< frames in a call where the throughput was measured
};

/// Of each round `{"schema", "key", "timing": {dataset: {"latency_us": [every frame],
/// "frames_per_s", "batch"}}, "calibration_us", "peak_rss_mb"}`, put together.
struct TimingRecord {
  std::map<std::string, MeasuredTimes> sets;  ///< by test set
  double calibration_us = 0;                  ///< median of the rounds
  double peak_rss_mb = 0;                     ///< largest of the rounds
};

/// The latency of one round in units of what calibration_us() took just before it, in the same
/// process: whatever clock rate the processor had then, both had. Of frames under a millisecond the
/// median counts; a longer one is seldom left alone on a busy machine, and the fastest counts.
double relative_latency(double median_us, double fastest_us, double calibration_us);

/// What determines the record of a round, whichever it is: the solver, the test sets, how the clock
/// is used, and the machine's processor.
std::string timing_key(const FitRecipe& recipe, std::span<const DatasetSpec> tests,
                       const TimingSettings& timing);

/// Puts all rounds together, one at least. Throws an exception of any kind where one is not such a
/// record.
TimingRecord timing_record_from_json(const std::vector<nlohmann::json>& rounds);

}  // namespace ertbench
