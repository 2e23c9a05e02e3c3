#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// A hash of this program with its own libraries that are loaded, and of `plugins`.
std::string program_hash(const std::vector<std::filesystem::path>& plugins);

/// Makes `folder` the result folder of a check, with a cache of its own in it. What another build
/// left there is removed, as the cache's keys know the experiment but not the code: with another's
/// datasets, fitted solvers and records a check would not see what changed in the program. What
/// this very program left is kept, so that an interrupted check goes on where it stopped.
///
/// The folder carries our mark, `.ertbench-check`; where it does not, nothing in it is removed.
/// Throws InputError where it holds results and no mark; they are left alone.
Cache prepare_check_folder(const std::filesystem::path& folder, const std::string& program);

class SolverRegistry;

struct CheckOptions {
  std::filesystem::path out;       ///< result folder; empty: results/NAME/check, or see `reuse`
  std::filesystem::path baseline;  ///< empty: results/baselines/NAME.json of the project
  int jobs = 1;                    ///< as of a run
  bool all = false;                ///< show every quantity, not just what changed
  bool update = false;             ///< write the baseline anew
  bool images = false;             ///< only compare images with stored ones, which takes seconds
  /// With `update`: training seeds behind the interval of a learned row. None: the experiment's
  /// "baseline_seeds", or the entry's seeds where there are `enough_seeds`, else `usual_seeds`.
  std::optional<int> seeds;
  /// With `update`: write a baseline that lets learned solvers become worse unnoticed by more than
  /// kNoticeLimits.
  bool accept_coarse = false;
  /// Take whatever `run` left in the cache and in its result folder (results/NAME), quicker, and
  /// blind to changes of the program since. Else everything is made by this very program.
  bool reuse = false;
  /// Only warn about times, as on another cpu: for machines that share their cores.
  bool warn_times = false;
};

/// The interval of a trained row for one training in a check reaches 36 standard deviations to each
/// side for three seeds, 9.4 for five, 5.7 for eight, 5.0 for ten; each seed costs a training of
/// every network.
inline constexpr int enough_seeds = 5;
inline constexpr int usual_seeds = 8;
inline constexpr int most_seeds = 100;  ///< of CheckOptions::seeds

/// Runs the experiment and compares its rows with the baseline, and today's images of the stored
/// networks and of the short trainings with their stored images; prints the comparison, with the
/// smallest worsening of every row and metric that it notices, and writes it to check.md in the
/// result folder. With `update` the baseline and the images of the short trainings are written
/// anew, whole or not at all, and what changed is printed; stored networks stay as they are.
/// Returns whether nothing regressed, or with `update` whether the baseline was written and the
/// stored networks are as they were.
///
/// Throws InputError, before anything is run, where there is no baseline, or where it cannot be
/// used: malformed, or made of other datasets or solvers.
bool check_experiment(const Experiment& experiment, SolverRegistry& registry,
                      const CheckOptions& options);

}  // namespace ertbench
