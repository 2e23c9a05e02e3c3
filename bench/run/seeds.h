#pragma once

#include <span>

#include "bench/record/accuracy_record.h"

namespace ertbench {

/// The results of one training seed on one test set.
struct SeedResult {
  int seed;
  const ScoredSet* set;
};

/// One row out of those of several seeds (at least one, all of the same frames). Each metric's mean
/// is the mean of the seeds' means. Interval and median are those of the frames, the value of a
/// frame being its mean over the seeds; a frame that is undefined for any seed counts as undefined
/// there, and in the row's `undefined_frames`. `fit_s` is the mean. `parameters` is the first
/// seed's; status and message are left to the caller.
ResultRow combine_seeds(std::span<const SeedResult> results);

}  // namespace ertbench
