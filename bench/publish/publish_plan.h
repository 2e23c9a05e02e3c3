#pragma once

#include <filesystem>
#include <set>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"
#include "bench/table/table.h"

namespace ertbench {

/// What the fits and the limits of an experiment will take, told from what those in the cache, or
/// the published ones, took.
struct PublishCost {
  std::string experiment;
  int fits = 0;        ///< of all solvers and seeds
  int kept = 0;        ///< of these, in the cache and of this code, or counted before
  int unknown = 0;     ///< of these, to be made, and never published: nobody knows what they take
  double seconds = 0;  ///< of those that are to be made
  double limit_seconds = 0;  ///< of the published limits that are of other probes or sets by now
};

/// The costs of several experiments, one after the other: a fit that two of them share is counted
/// once.
class PublishPlan {
 public:
  /// `project`: whose results/published says what fits and limits took.
  PublishPlan(std::filesystem::path project, Cache cache);

  void add(const Experiment& experiment);

  /// A row an experiment, and their sum; below it how long that is with so many fits at a time.
  Table table(int jobs) const;

 private:
  std::filesystem::path project_;
  Cache cache_;
  std::set<std::filesystem::path> counted_;
  std::vector<PublishCost> costs_;
};

}  // namespace ertbench
