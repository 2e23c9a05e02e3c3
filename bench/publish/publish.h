#pragma once

#include <cstdint>
#include <filesystem>

#include "bench/experiment/experiment.h"
#include "bench/record/cache.h"

namespace ertbench {

/// Largest picture that is published.
inline constexpr std::uintmax_t most_picture_bytes = 150 * 1000;

/// Throws InputError where the project's tree differs from its last commit, where the program was
/// built of other sources, or where there is no git. Changes below results/published and of the
/// rendered pages do not count: publishing makes them.
void require_committed(const std::filesystem::path& project);

/// Runs what is missing of the experiment, with `jobs` processes at a time, and puts its results
/// into results/published/NAME of the project, whole or not at all: summary.json, and of the
/// rest what a page of the project links to or takes numbers from; pictures have a palette;
/// templates of pages in that folder stay. The experiment's "made_by" says which command's results
/// these are.
///
/// Which earlier records may be reused is up to the cache (Reuse::clean: none of a build whose
/// sources were not committed). Returns the number of jobs that failed; they stay in the results
/// with their reason. Published limits (`ertbench limit`) of the same sets and probes stay where
/// none were computed since. Throws InputError where a figure could not be drawn or is too large,
/// or where limits would be lost. What was published before then stays.
int publish_experiment(const Experiment& experiment, const std::filesystem::path& project,
                       const Cache& cache, int jobs);

/// Writes the tables and charts of results/published/NAME again, as far as its summary.json holds
/// what they show, in the words and the form that this program has; the other files stay. Throws
/// InputError for a summary that is missing or damaged, and where a figure could not be drawn.
void redraw_published(const std::string& name, const std::filesystem::path& project);

/// Leaves in the folder `made` what readers of results/published/NAME, the folder `published`,
/// need: summary.json, and the files that a page of the project names.
void prune(const std::filesystem::path& made, const std::filesystem::path& project,
           const std::filesystem::path& published);

/// Renders every page of the project. All of them or none: throws InputError naming the first place
/// that cannot be rendered.
void publish_pages(const std::filesystem::path& project);

}  // namespace ertbench
