#pragma once

#include <filesystem>
#include <optional>

#include "bench/experiment/experiment.h"

namespace ertbench {

class SolverRegistry;

struct CheckOptions {
  std::filesystem::path out;       ///< result folder; empty: results/NAME/check, or see `reuse`
  std::filesystem::path baseline;  ///< empty: results/baselines/NAME.json of the project
  int jobs = 1;                    ///< as for a run
  bool all = false;                ///< show every quantity, not only changes
  bool update = false;             ///< write a new baseline
  bool images = false;             ///< only compare images with stored ones, which takes seconds
  /// With `update`: number of training seeds for a learned row. Nothing: the experiment's
  /// "baseline_seeds", or the entry's seeds if there are `enough_seeds`, otherwise `usual_seeds`.
  std::optional<int> seeds;
  /// With `update`: accept a baseline that does not notice worsenings of kNoticeLimits.
  bool accept_coarse = false;
  /// Use the results of `run` in the cache and in results/NAME: faster, but blind to changes of the
  /// program since. Otherwise everything is made by this very program.
  bool reuse = false;
  /// Only warn about times, as on another cpu: for machines with shared cores.
  bool warn_times = false;
};

/// With one training in a check, the interval of a trained row reaches 36 standard deviations to
/// each side for three seeds, 9.4 for five, 5.7 for eight, 5.0 for ten; each seed costs a training
/// of every network.
inline constexpr int enough_seeds = 5;
inline constexpr int usual_seeds = 8;
inline constexpr int most_seeds = 100;  ///< of CheckOptions::seeds

/// Runs the experiment and compares its rows with the baseline, and today's images of the stored
/// networks and of the short trainings with their stored images. Prints the comparison, with the
/// smallest worsening that it notices for every row and metric, and writes it to check.md in the
/// result folder. With `update` the baseline and the images of the short trainings are replaced,
/// all or none, and the changes are printed; stored networks are left unchanged. Returns true if
/// nothing regressed; with `update` if the baseline was written and stored networks agree.
///
/// Throws InputError, before anything is run, if the baseline is missing, malformed, or made with
/// other datasets or solvers.
bool check_experiment(const Experiment& experiment, SolverRegistry& registry,
                      const CheckOptions& options);

}  // namespace ertbench
