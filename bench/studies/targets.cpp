#include "bench/studies/targets.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "bench/report/report.h"
#include "bench/studies/study_text.h"
#include "bench/studies/targets_figure.h"
#include "bench/studies/targets_gallery.h"
#include "bench/studies/targets_tables.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

json target_number(const std::optional<double>& value) { return value ? json(*value) : json(); }

json target_json(const std::optional<Estimate>& estimate) {
  if (!estimate) return {{"mean", nullptr}, {"ci95", nullptr}};
  return {{"mean", estimate->value}, {"ci95", {estimate->ci95.low, estimate->ci95.high}}};
}

json target_json(const TargetGaps& gaps) {
  const ResolvableGap& resolvable = gaps.resolvable;
  json out = {{"state", name_of(resolvable.state)},
              {"value", target_number(resolvable.gap_mm)},
              {"ci95", {target_number(resolvable.low_mm), target_number(resolvable.high_mm)}},
              {"share", kResolvedShare},
              {"scenes", gaps.scenes},
              {"bins", json::array()}};
  if (gaps.scenes > 0) out["set_mm"] = {gaps.least_mm, gaps.largest_mm};
  for (const GapBin& bin : gaps.bins) {
    json& one = out["bins"].emplace_back();
    one = {{"from_mm", bin.low_mm},
           {"to_mm", bin.high_mm},
           {"mean_gap_mm", bin.mean_gap_mm},
           {"scenes", bin.scenes},
           {"told_apart", target_json(bin.told_apart)}};
  }
  return out;
}

/// "falling law, 50 dB absolute".
std::string conditions_of(const StudyInput& input) {
  std::vector<std::string> noises;
  for (const std::string& set : input.spec.sets) {
    const std::string noise = noise_text(input.set_spec(set).noise);
    if (std::find(noises.begin(), noises.end(), noise) == noises.end()) noises.push_back(noise);
  }
  std::string out = input.law() + " law";
  for (std::size_t n = 0; n < noises.size(); ++n) out += (n == 0 ? ", " : " and ") + noises[n];
  return out;
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

std::vector<std::size_t> gallery_frames(std::span<const TargetFrame> frames) {
  std::map<int, std::size_t> first;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (frames[f].counts && frames[f].contacts() > 0) first.emplace(frames[f].contacts(), f);
  }
  std::vector<std::size_t> out;
  for (const auto& [contacts, frame] : first) out.push_back(frame);
  return out;
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
  const std::vector<std::size_t> gallery = gallery_frames(frames);
  for (const std::size_t frame : gallery) out.gallery.push_back(frames[frame]);
  for (const TargetReadings& given : readings) {
    if (given.found.size() != frames.size()) {
      throw std::invalid_argument("targets: " + given.label + ": a reading for each frame");
    }
    std::vector<std::optional<ContactScore>> scores;
    for (std::size_t f = 0; f < frames.size(); ++f) {
      scores.emplace_back();
      if (!given.found[f]) continue;
      scores.back() = match_targets(frames[f], given.found[f]->contacts, distances).score;
    }
    TargetSolver& solver = out.solvers.emplace_back();
    solver.label = given.label;
    solver.failure = given.failure;
    solver.counts = count_targets(frames, scores);
    solver.gaps = measure_gaps(gap_trials(frames, scores));
    for (const std::size_t frame : gallery) {
      solver.gallery.emplace_back();
      const FrameReading* reading = given.found[frame];
      if (!reading) continue;
      solver.gallery.back() = {reading->contacts,
                               match_targets(frames[frame], reading->contacts, distances)};
    }
  }
  return out;
}

Targets::Targets(const StudyInput& input)
    : circumstances_{input.spec.name, conditions_of(input),
                     input.experiment.contacts.distances(input.experiment.sensor),
                     input.experiment.sensor.sheet} {
  std::vector<TargetReadings> readings;
  for (const std::string& label : input.labels()) readings.push_back(target_readings(input, label));
  results_ = target_results(target_frames(input), readings, circumstances_.distances);
}

json Targets::summary() const {
  json out = {{"conditions", circumstances_.conditions},
              {"match_mm", circumstances_.distances.match},
              {"ospa_mm", circumstances_.distances.ospa}};
  for (const TargetSolver& solver : results_.solvers) {
    json& one = out["solvers"][solver.label];
    one = {{"by_count", json::object()}, {"resolvable_gap_mm", target_json(solver.gaps)}};
    if (!solver.failure.empty()) one["failure"] = solver.failure;
    for (const auto& [contacts, count] : solver.counts) {
      json& numbers = one["by_count"][std::to_string(contacts)];
      numbers = {{"frames", count.frames}, {"scenes", count.scenes}};
      for (const auto& [key, estimate] : count.metrics) numbers[key] = target_json(estimate);
    }
  }
  return out;
}

std::vector<Headline> Targets::headlines() const {
  std::vector<Headline> out;
  for (const TargetSolver& solver : results_.solvers) {
    if (!solver.failure.empty()) continue;
    for (const auto& [contacts, count] : solver.counts) {
      if (contacts == 0) continue;
      const std::string of =
          contacts == 1 ? "1 contact: " : std::to_string(contacts) + " contacts: ";
      for (const TargetMetric& metric : target_metrics()) {
        if (metric.key != "f1" && metric.key != "ospa_mm") continue;
        out.push_back({solver.label, of + metric.heading, metric.decimals,
                       value_of(count.metrics.at(metric.key))});
      }
    }
  }
  return out;
}

std::vector<ReportSection> Targets::report(const std::string& title,
                                           const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Several contacts (D.3)";
  section.text =
      "How many of one to several contacts at rest are found, how many ghosts come with them, and "
      "how close two may be before they are found as one.";
  section.tables = {targets_count_table(circumstances_, results_),
                    targets_gap_table(circumstances_, results_)};
  section.notes = targets_notes(circumstances_);
  section.figures = {targets_chart(circumstances_, results_, without_law(title), folder),
                     targets_gallery(circumstances_, results_, without_law(title), folder)};
  write_targets_files(circumstances_, {title, section.text, section.tables, section.notes, {}},
                      results_, folder);
  return {section};
}

}  // namespace ertbench
