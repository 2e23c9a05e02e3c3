#include "bench/studies/targets.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

json target_json(const std::optional<Estimate>& estimate) {
  if (!estimate) return {{"mean", nullptr}, {"ci95", nullptr}};
  return to_json(estimate, "mean");
}

json target_json(const TargetGaps& gaps) {
  const ResolvableGap& resolvable = gaps.resolvable;
  json out = {{"state", name_of(resolvable.state)},
              {"value", to_json(resolvable.gap_mm)},
              {"ci95", {to_json(resolvable.low_mm), to_json(resolvable.high_mm)}},
              {"share", kResolvedShare},
              {"scenes", gaps.scenes},
              {"bins", json::array()}};
  if (gaps.scenes > 0) out["set_mm"] = {gaps.least_mm, gaps.largest_mm};
  for (const GapBin& bin : gaps.bins) {
    out["bins"].push_back({{"from_mm", bin.low_mm},
                           {"to_mm", bin.high_mm},
                           {"mean_gap_mm", bin.mean_gap_mm},
                           {"scenes", bin.scenes},
                           {"told_apart", target_json(bin.told_apart)}});
  }
  return out;
}

json target_json(const TargetSolver& solver) {
  json out = {{"by_count", json::object()}, {"resolvable_gap_mm", target_json(solver.gaps)}};
  if (!solver.failure.empty()) out["failure"] = solver.failure;
  for (const auto& [contacts, count] : solver.counts) {
    json& numbers = out["by_count"][std::to_string(contacts)];
    numbers = {{"frames", count.frames}, {"scenes", count.scenes}};
    for (const auto& [key, estimate] : count.metrics) numbers[key] = target_json(estimate);
  }
  return out;
}

/// "falling law, 50 dB absolute".
std::string conditions_of(const StudyInput& input) {
  const auto noise_of = [&](const std::string& set) {
    return noise_text(input.set_spec(set).noise);
  };
  return input.law() + " law, " + joined(distinct(input.spec.sets, noise_of), " and ");
}

/// The truths of all sets, one behind the other.
std::vector<TargetFrame> target_frames(const StudyInput& input) {
  std::vector<TargetFrame> frames;
  std::vector<std::size_t> set_of;
  std::size_t first_scene = 0;  // of the set, when the scenes of all sets are counted
  for (std::size_t s = 0; s < input.spec.sets.size(); ++s) {
    const std::string& set = input.spec.sets[s];
    const DatasetSpec& spec = input.set_spec(set);
    const DatasetFile file = input.open(set);
    const std::vector<Scene> scenes = file.scenes(0, file.size());
    std::size_t next = first_scene;
    for (std::size_t f = 0; f < scenes.size(); ++f) {
      const std::size_t number = first_scene + spec.scene_number(f);
      frames.push_back(target_frame(spec.sensor, scenes[f], number));
      set_of.push_back(s);
      next = number + 1;
    }
    first_scene = next;
  }
  leave_out_pair_sets(frames, set_of);
  return frames;
}

TargetReadings target_readings(const StudyInput& input, const std::string& label) {
  TargetReadings out;
  out.label = label;
  for (const std::string& set : input.spec.sets) {
    const auto* readings = input.readings(label, set);
    const std::size_t frames = input.set_spec(set).count;
    if (readings && readings->size() == frames) {
      for (const FrameReading& reading : *readings) out.found.push_back(&reading);
      continue;
    }
    out.found.insert(out.found.end(), frames, nullptr);
    const std::string why = input.failure(label);
    out.failure = why.empty() ? "no readings of " + set : why;
  }
  return out;
}

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

/// Notes on reading the tables.
std::vector<std::string> targets_notes(const ContactDistances& distances) {
  return {
      "A detected contact belongs to a true one where the optimal assignment puts them together "
      "within " +
          number_text(distances.match) +
          " mm; the others are false positives. Precision is the share of the detected contacts "
          "that belong to a true one, recall the share of the true ones that were detected, F1 the "
          "harmonic mean of both: all over the contacts of all frames together. Right number: the "
          "share of frames with exactly as many contacts detected as there are. Localisation "
          "error: mean distance of the detected contacts from theirs. OSPA: mean distance of the "
          "two sets, in which a contact too many or too few is " +
          number_text(distances.ospa) + " mm away.",
      "Brackets: 95 % intervals by the bootstrap over scenes; frames that are draws of one scene "
      "stay together; where all scenes give the same number they have no width. Shares of scenes "
      "or frames that each count once have Wilson's. Where a solver was trained with several "
      "seeds, these numbers are of the first.",
      "Gap: distance between the circles around the two footprints. Resolved: each of the two "
      "contacts was detected, by a contact of its own. The resolvable gap is the least from which "
      "on " +
          number_text(100 * kResolvedShare) +
          " % are resolved: where the isotonic fit (pool adjacent violators) of the share against "
          "the gap reaches that, by its value and not by a limit of its uncertainty, and at "
          "least " +
          std::to_string(kLeastResolvedScenes) +
          " scenes lie there and above. In its interval \"< set\" is below the least gap there "
          "was, \"> set\" above the largest; the bootstrap of an isotonic fit is a rough one.",
      "A set that holds pairs alone, beside another with pairs among its scenes, serves the gaps "
      "and not the comparison of numbers of contacts."};
}

void add_headlines(const TargetSolver& solver, std::vector<Headline>& out) {
  if (!solver.failure.empty()) return;
  for (const auto& [contacts, count] : solver.counts) {
    if (contacts == 0) continue;
    const std::string of =
        std::to_string(contacts) + (contacts == 1 ? " contact: " : " contacts: ");
    for (const TargetMetric& metric : target_metrics()) {
      if (metric.key != "f1" && metric.key != "ospa_mm") continue;
      out.push_back({solver.label, of + metric.heading, metric.decimals,
                     value_of(count.metrics.at(metric.key))});
    }
  }
}

}  // namespace

TargetResults target_results(std::span<const TargetFrame> frames,
                             std::span<const TargetReadings> readings,
                             const ContactDistances& distances) {
  TargetResults out;
  std::set<int> numbers;
  for (const TargetFrame& frame : frames) {
    if (frame.counts) numbers.insert(frame.contacts());
  }
  out.numbers.assign(numbers.begin(), numbers.end());
  for (const TargetReadings& given : readings) {
    if (given.found.size() != frames.size()) {
      throw std::invalid_argument("targets: " + given.label + ": a reading for each frame");
    }
    std::vector<std::optional<ContactScore>> scores;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      scores.emplace_back();
      if (!given.found[f]) continue;
      scores.back() = match_targets(frames[f], given.found[f]->contacts, distances);
    }
    TargetSolver& solver = out.solvers.emplace_back();
    solver.label = given.label;
    solver.failure = given.failure;
    solver.counts = count_targets(frames, scores);
    solver.gaps = measure_gaps(gap_trials(frames, scores));
  }
  return out;
}

TableSection targets_count_table(const TargetCircumstances& circumstances,
                                 const TargetResults& results) {
  TableSection section;
  section.caption = "Contacts detected, by their number: " + circumstances.conditions;
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
  section.caption = "Two contacts resolved, by the gap between them: " + circumstances.conditions;
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
      const auto found = std::ranges::find(own, entry.first, &GapBin::low_mm);
      row.push_back(found == own.end() ? Cell("—") : estimate_cell(found->told_apart, 2));
    }
  }
  return section;
}

TableSection targets_count_data(const TargetResults& results) {
  TableSection section;
  section.columns = {"solver", "contacts", "frames", "scenes",
                     "metric", "value",    "ci_low", "ci_high"};
  for (const TargetSolver& solver : results.solvers) {
    for (const auto& [contacts, count] : solver.counts) {
      for (const TargetMetric& metric : target_metrics()) {
        std::vector<Cell>& row = section.rows.emplace_back();
        row = {solver.label, std::to_string(contacts), std::to_string(count.frames),
               std::to_string(count.scenes), metric.key};
        for (Cell& cell : exact_cells(count.metrics.at(metric.key))) row.push_back(cell);
      }
    }
  }
  return section;
}

TableSection targets_gap_data(const TargetResults& results) {
  TableSection section;
  section.columns = {"solver", "quantity", "from_mm", "to_mm",  "mean_gap_mm",
                     "scenes", "state",    "value",   "ci_low", "ci_high"};
  for (const TargetSolver& solver : results.solvers) {
    const TargetGaps& gaps = solver.gaps;
    if (gaps.scenes == 0) continue;
    for (const GapBin& bin : gaps.bins) {
      std::vector<Cell>& row = section.rows.emplace_back();
      row = {solver.label,
             "told_apart",
             exact_cell(bin.low_mm),
             exact_cell(bin.high_mm),
             exact_cell(bin.mean_gap_mm),
             std::to_string(bin.scenes),
             ""};
      for (Cell& cell : exact_cells(bin.told_apart)) row.push_back(cell);
    }
    const ResolvableGap& resolvable = gaps.resolvable;
    section.rows.push_back({solver.label, "resolvable_gap_mm", exact_cell(gaps.least_mm),
                            exact_cell(gaps.largest_mm), "", std::to_string(gaps.scenes),
                            name_of(resolvable.state), exact_cell(resolvable.gap_mm),
                            exact_cell(resolvable.low_mm), exact_cell(resolvable.high_mm)});
  }
  return section;
}

Study study_of_targets(const TargetCircumstances& circumstances, const TargetResults& results) {
  const auto shared = std::make_shared<TargetResults>(results);
  Study study(circumstances.name, "Several contacts (D.3)",
              {{"conditions", circumstances.conditions},
               {"match_mm", circumstances.distances.match},
               {"ospa_mm", circumstances.distances.ospa}});
  for (const TargetSolver& solver : results.solvers) {
    study.numbers["solvers"][solver.label] = target_json(solver);
    add_headlines(solver, study.best);
  }
  StudySection& section = study.sections.front();
  section.report.text =
      "How many of one to several contacts at rest are detected, how many false positives come "
      "with them, and how close two may be before they are detected as one.";
  section.report.tables = {targets_count_table(circumstances, results),
                           targets_gap_table(circumstances, results)};
  section.report.notes = targets_notes(circumstances.distances);
  section.figures = {targets_chart(circumstances, shared)};
  section.data = {{"", targets_count_data(results)}, {"_gaps", targets_gap_data(results)}};
  return study;
}

Study targets_study(const StudyInput& input) {
  std::vector<TargetReadings> readings;
  for (const std::string& label : input.labels()) readings.push_back(target_readings(input, label));
  const TargetCircumstances circumstances{
      input.spec.name, conditions_of(input),
      input.experiment.contacts.distances(input.experiment.sensor)};
  return study_of_targets(circumstances,
                          target_results(target_frames(input), readings, circumstances.distances));
}

}  // namespace ertbench
