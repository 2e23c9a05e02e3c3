#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "core/json.h"

namespace ertbench {

/// A result in results/published whose times and whose other numbers may be made apart.
struct PublishedResult {
  std::filesystem::path folder;
  JsonValue summary;  ///< summary.json
  std::vector<ResultRow> rows;
};

/// That of the experiment in `folder`. Throws InputError for one that is not published or was not
/// timed, whose experiment has other datasets or labels than it had, or whose studies count times
/// in: it has to be published again as a whole.
PublishedResult read_published(const Experiment& experiment, const std::filesystem::path& folder);

/// What summary.json is to say under "clocks" of times that were taken apart from all else: "date",
/// "cpu", "system", "build", "together_with": names of results timed in the same rounds,
/// "briefly_trained": labels that were trained for the clock alone. Of times that were taken with
/// the rest it is made of the result's provenance.
nlohmann::json clocks_of(const PublishedResult& published);

/// The same for the tables' legends.
std::string clocks_sentence(const nlohmann::json& clocks);

/// Gives the rows of the experiment, made again without times, those of `published`. Throws
/// InputError where a solver that was scored has no published time.
void take_times(const PublishedResult& published, const Experiment& experiment,
                std::vector<ResultRow>& rows);

/// Writes the files of `made`, a folder of the experiment's results with such rows, again that say
/// when and with what the times were taken. Returns how many figures could not be drawn.
std::size_t write_clocks(const PublishedResult& published, const Experiment& experiment,
                         const std::vector<ResultRow>& rows, const std::filesystem::path& made);

/// Writes the files of a published result again that follow from `rows` (rewrite_results), with
/// `summary`, which has "clocks" where its times were taken apart. Whole or not at all: throws
/// InputError where a figure cannot be drawn.
void rewrite_published(const Experiment& experiment, const std::filesystem::path& folder,
                       const std::vector<ResultRow>& rows, const nlohmann::json& summary);

/// The same with the numbers that it has, after a change of how tables and charts look. Throws
/// InputError where read_published does, but not for one that was not timed.
void redraw_published(const Experiment& experiment, const std::filesystem::path& folder);

}  // namespace ertbench
