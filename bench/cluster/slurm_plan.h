#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// What an element of an array makes, by name: datasets; entries ("dd-ert.seed2") to be fitted and
/// scored; labels to be timed or to climb ladders.
using Units = std::vector<std::string>;

/// One sbatch: an array, or a job of one element.
struct SlurmPart {
  std::string name;             ///< "datasets", a stage's name, or "report"
  std::vector<Units> elements;  ///< of the report one without units
  bool exclusive = false;       ///< its node is its own
};

/// What is not to be planned: it waits or runs already.
struct LiveUnits {
  std::set<std::pair<std::string, std::string>> units;  ///< part and unit

  bool has(const std::string& part, const std::string& unit) const {
    return units.count({part, unit}) > 0;
  }
};

struct SlurmPlanSettings {
  std::filesystem::path out;      ///< result folder
  std::vector<std::string> only;  ///< as of RunOptions
  int most_elements = 1001;       ///< of an array; more units than that share elements
};

/// Labels that are timed in one go, on one node: enough for most experiments to be all on one.
inline constexpr std::size_t most_timed_together = 64;

/// What is missing, by the records in the result folder and the datasets in the cache, in the order
/// in which it is to be made; the report always comes last, alone where nothing is missing.
/// `experiment` has every entry described as read_experiment does.
std::vector<SlurmPart> slurm_plan(const Experiment& experiment, const Cache& cache,
                                  const LiveUnits& live, const SlurmPlanSettings& settings);

/// The experiment with those solvers alone whose entry or label is a unit of the list.
Experiment restricted_to(const Experiment& experiment, const Units& units);

}  // namespace ertbench
