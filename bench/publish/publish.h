#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

class SolverRegistry;
struct LoadResults;

/// Throws InputError where the project's tree is not what its last commit says, where the program
/// was built of other sources, or where there is no git. Changes below results/published and of the
/// rendered pages do not count: publishing makes them.
void require_committed(const std::filesystem::path& project);

/// What of an experiment is made and published.
enum class Publishing {
  all,     ///< what `ertbench run` makes
  scores,  ///< the same but for the times, which stay as they were published: the inverse of Clocks
  models   ///< the comparison of the sheet's models on its scenes, as `ertbench fidelity` makes it
};

/// Runs what is missing of the experiment, with `jobs` at a time, and puts its results into
/// results/published/NAME of the project, whole or not at all. What may be reused of earlier runs
/// is the cache's to say (Cache::reuse). Templates of pages in that folder stay. Returns the number
/// of jobs that failed; they stay in the results with what happened. Of `scores` throws InputError
/// where read_published or take_times do.
int publish_experiment(const Experiment& experiment, const std::filesystem::path& project,
                       const Cache& cache, int jobs, Publishing what = Publishing::all);

/// Throws InputError naming the first solver that other work of the machine kept from its own while
/// it was measured; `published` is what the message speaks of.
void require_undisturbed(const LoadResults& results, const std::filesystem::path& published);

/// The same of what `ertbench timing load` makes of the experiment with its usual deadlines, each
/// solver measured again, one after the other, and refused where the machine was busy
/// (require_undisturbed). `registry`: that the experiment was read with. Returns the number of
/// solvers that failed.
int publish_load(const Experiment& experiment, SolverRegistry& registry,
                 const std::filesystem::path& project, const Cache& cache);

/// Renders every page of the project, and the pages of the latencies and of the builds. All of them
/// or none: throws InputError naming the first place that cannot be rendered or has a number typed
/// by hand.
void publish_pages(const std::filesystem::path& project);

/// The pages with their texts, as they ought to stand.
std::vector<std::pair<std::filesystem::path, std::string>> rendered_pages(
    const std::filesystem::path& project);

}  // namespace ertbench
