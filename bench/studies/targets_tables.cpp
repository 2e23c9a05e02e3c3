#include "bench/studies/targets_tables.h"

#include <algorithm>
#include <map>

#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// The solver's name, and below it what went wrong.
Cell solver_cell(const TargetSolver& solver) {
  Cell cell(solver.label);
  if (!solver.failure.empty()) cell.lines.push_back(solver.failure);
  return cell;
}

/// The intervals of gaps in which any solver has scenes, by their lower end: bins of the same
/// scenes are the same.
std::map<double, GapBin> all_gap_bins(const TargetResults& results) {
  std::map<double, GapBin> bins;
  for (const TargetSolver& solver : results.solvers) {
    for (const GapBin& bin : solver.gaps.bins) bins.emplace(bin.low_mm, bin);
  }
  return bins;
}

std::vector<Cell> targets_data_row(std::vector<Cell> words, const std::optional<double>& value,
                                   const std::optional<double>& low,
                                   const std::optional<double>& high) {
  for (const auto& number : {value, low, high}) words.push_back(exact_cell(number));
  return words;
}

}  // namespace

TableSection targets_count_table(const TargetCircumstances& circumstances,
                                 const TargetResults& results) {
  TableSection section;
  section.caption = "Contacts found, by their number: " + circumstances.conditions;
  section.columns = {{"solver", Align::left}, {"contacts"}, {"scenes"}};
  for (const TargetMetric& metric : target_metrics()) section.columns.emplace_back(metric.heading);
  for (const int contacts : results.numbers) {
    for (const TargetSolver& solver : results.solvers) {
      std::vector<Cell>& row = section.rows.emplace_back();
      row = {solver_cell(solver), std::to_string(contacts)};
      const auto count = solver.counts.find(contacts);
      if (count == solver.counts.end()) {
        row.resize(section.columns.size(), "—");
        continue;
      }
      row.emplace_back(std::to_string(count->second.scenes));
      for (const TargetMetric& metric : target_metrics()) {
        row.push_back(estimate_cell(count->second.metrics.at(metric.key), metric.decimals));
      }
    }
  }
  return section;
}

TableSection targets_gap_table(const TargetCircumstances& circumstances,
                               const TargetResults& results) {
  TableSection section;
  section.caption = "Two contacts told apart, by the gap between them: " + circumstances.conditions;
  section.columns = {{"solver", Align::left}, {"scenes"}, {"resolvable gap (mm)"}};
  const std::map<double, GapBin> bins = all_gap_bins(results);
  for (const auto& [low, bin] : bins) {
    section.columns.emplace_back(number_text(bin.low_mm) + " to " + number_text(bin.high_mm) +
                                 " mm");
  }
  for (const TargetSolver& solver : results.solvers) {
    std::vector<Cell>& row = section.rows.emplace_back();
    row = {solver_cell(solver)};
    if (solver.gaps.scenes == 0) {
      row.resize(section.columns.size(), "—");
      continue;
    }
    Cell resolvable(solver.gaps.resolvable.text());
    resolvable.interval = solver.gaps.resolvable.interval();
    row.emplace_back(std::to_string(solver.gaps.scenes));
    row.push_back(resolvable);
    for (const auto& entry : bins) {
      const auto& own = solver.gaps.bins;
      const double low_mm = entry.second.low_mm;
      const auto found = std::find_if(own.begin(), own.end(),
                                      [&](const GapBin& one) { return one.low_mm == low_mm; });
      row.push_back(found == own.end() ? Cell("—") : estimate_cell(found->told_apart, 2));
    }
  }
  return section;
}

std::vector<std::string> targets_notes(const TargetCircumstances& circumstances) {
  const ContactDistances& distances = circumstances.distances;
  return {
      "A found contact belongs to a true one where the optimal assignment puts them together "
      "within " +
          number_text(distances.match) +
          " mm; the others are ghosts. Precision is the share of the found contacts that belong to "
          "a true one, recall the share of the true ones that were found, F1 the harmonic mean of "
          "both: all over the contacts of all frames together. Right number: the share of frames "
          "with exactly as many contacts found as there are. Location error: mean distance of the "
          "found contacts from theirs. OSPA: mean distance of the two sets, in which a contact too "
          "many or too few is " +
          number_text(distances.ospa) + " mm away.",
      "Brackets: 95 % intervals by the bootstrap over scenes; frames that are draws of one scene "
      "stay together; where all scenes give the same number they have no width. Shares of scenes "
      "or frames that each count once have Wilson's. Where a solver was trained with several "
      "seeds, "
      "these numbers are of the first.",
      "Gap: distance between the circles around the two footprints. Told apart: each of the two "
      "contacts was found, by a found one of its own. The resolvable gap is the least from which "
      "on " +
          number_text(100 * kResolvedShare) +
          " % are told apart: where the isotonic fit (pool adjacent violators) of the share "
          "against "
          "the gap reaches that, by its value and not by a limit of its uncertainty, and at "
          "least " +
          std::to_string(kLeastResolvedScenes) +
          " scenes lie there and above. In its interval \"< set\" is below the least gap there "
          "was, "
          "\"> set\" above the largest; the bootstrap of an isotonic fit is a rough one.",
      "A set that holds pairs alone, beside another with pairs among its scenes, serves the gaps "
      "and not the comparison of numbers of contacts."};
}

TableSection targets_count_data(const TargetResults& results) {
  TableSection section;
  for (const char* title :
       {"solver", "contacts", "frames", "scenes", "metric", "value", "ci_low", "ci_high"}) {
    section.columns.emplace_back(title);
  }
  for (const TargetSolver& solver : results.solvers) {
    for (const auto& [contacts, count] : solver.counts) {
      for (const TargetMetric& metric : target_metrics()) {
        const std::vector<Cell> words = {solver.label, std::to_string(contacts),
                                         std::to_string(count.frames), std::to_string(count.scenes),
                                         metric.key};
        const auto& estimate = count.metrics.at(metric.key);
        section.rows.push_back(estimate ? targets_data_row(words, estimate->value,
                                                           estimate->ci95.low, estimate->ci95.high)
                                        : targets_data_row(words, {}, {}, {}));
      }
    }
  }
  return section;
}

TableSection targets_gap_data(const TargetResults& results) {
  TableSection section;
  for (const char* title : {"solver", "quantity", "from_mm", "to_mm", "mean_gap_mm", "scenes",
                            "state", "value", "ci_low", "ci_high"}) {
    section.columns.emplace_back(title);
  }
  for (const TargetSolver& solver : results.solvers) {
    const TargetGaps& gaps = solver.gaps;
    if (gaps.scenes == 0) continue;
    for (const GapBin& bin : gaps.bins) {
      section.rows.push_back(targets_data_row(
          {solver.label, "told_apart", exact_cell(bin.low_mm), exact_cell(bin.high_mm),
           exact_cell(bin.mean_gap_mm), std::to_string(bin.scenes), ""},
          bin.told_apart.value, bin.told_apart.ci95.low, bin.told_apart.ci95.high));
    }
    section.rows.push_back(targets_data_row(
        {solver.label, "resolvable_gap_mm", exact_cell(gaps.least_mm), exact_cell(gaps.largest_mm),
         "", std::to_string(gaps.scenes), name_of(gaps.resolvable.state)},
        gaps.resolvable.gap_mm, gaps.resolvable.low_mm, gaps.resolvable.high_mm));
  }
  return section;
}

void write_targets_files(const TargetCircumstances& circumstances, const Table& table,
                         const TargetResults& results, const std::filesystem::path& folder) {
  const std::string& name = circumstances.name;
  write_file_atomically(folder / (name + ".md"), markdown_of(table));
  write_file_atomically(folder / (name + ".csv"), csv_of(targets_count_data(results)));
  write_file_atomically(folder / (name + "_gaps.csv"), csv_of(targets_gap_data(results)));
}

}  // namespace ertbench
