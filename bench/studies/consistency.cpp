#include "bench/studies/consistency.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "bench/report/report.h"
#include "bench/studies/study.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

constexpr std::size_t frames_of_a_block = 10;  ///< neighbours in time are alike
constexpr std::size_t frames_around = 2;       ///< on each side, that an outlier is told by
constexpr double normal_half_range = 1.349;    ///< of the middle half of normal values

std::size_t blocks_of(std::size_t frames) {
  return std::max<std::size_t>(1, (frames + frames_of_a_block - 1) / frames_of_a_block);
}

double relative_spread(const std::vector<double>& values) {
  const SortedValues sorted = values;
  const double middle = std::abs(median(sorted));
  if (middle == 0) return 0;
  const double range = interpolated_quantile(sorted, 0.75) - interpolated_quantile(sorted, 0.25);
  return range / normal_half_range / middle;
}

/// The relative spread of values in their blocks.
std::optional<Estimate> spread_estimate(const std::vector<std::vector<double>>& blocks,
                                        const std::string& name) {
  std::vector<std::vector<double>> filled_blocks;
  std::vector<double> all;
  for (const std::vector<double>& block : blocks) {
    if (block.empty()) continue;
    filled_blocks.push_back(block);
    all.insert(all.end(), block.begin(), block.end());
  }
  if (all.size() < 2) return std::nullopt;
  const auto spread = [&](std::span<const std::size_t> drawn) {
    std::vector<double> values;
    for (const std::size_t b : drawn) {
      values.insert(values.end(), filled_blocks[b].begin(), filled_blocks[b].end());
    }
    return relative_spread(values);
  };
  return Estimate{relative_spread(all),
                  bootstrap_interval_of_groups(filled_blocks.size(), spread, name)};
}

/// Values of frames, kept by blocks.
class FrameValues {
 public:
  explicit FrameValues(std::size_t frames)
      : errors_(blocks_of(frames)), blocks_(blocks_of(frames)) {}

  void add(std::size_t frame, double value) {
    errors_.add(frame / frames_of_a_block, value);
    blocks_[frame / frames_of_a_block].push_back(value);
  }
  std::optional<Estimate> mean(const std::string& name) const { return errors_.mean(name); }
  std::optional<Estimate> median(const std::string& name) const {
    return errors_.quantile(0.5, name);
  }
  std::optional<Estimate> spread(const std::string& name) const {
    return spread_estimate(blocks_, name);
  }

 private:
  GroupedErrors errors_;
  std::vector<std::vector<double>> blocks_;
};

/// The medians of x and of y; at least one place.
Vector2d middle_of(const std::vector<Vector2d>& places) {
  std::vector<double> x;
  std::vector<double> y;
  for (const Vector2d& place : places) {
    x.push_back(place.x());
    y.push_back(place.y());
  }
  return {median(x), median(y)};
}

bool is_outlier(const MeasuredPath& path, std::size_t frame, double limit_mm) {
  std::vector<Vector2d> around;
  const std::size_t first = frame >= frames_around ? frame - frames_around : 0;
  for (std::size_t f = first; f < std::min(path.size(), frame + frames_around + 1); ++f) {
    if (f != frame && path[f]) around.push_back(*path[f]);
  }
  return around.size() >= 2 && (*path[frame] - middle_of(around)).norm() > limit_mm;
}

void score_path(const MeasuredPath& path, const ConsistencyInput& input, const std::string& key,
                ConsistencyScores& scores) {
  FrameValues steps(path.size());
  FrameValues jerks(path.size());
  FrameValues apart(path.size());
  for (std::size_t f = 0; f < path.size(); ++f) {
    if (!path[f]) continue;
    if (f >= 1 && path[f - 1]) steps.add(f, (*path[f] - *path[f - 1]).norm());
    if (f >= 3 && path[f - 1] && path[f - 2] && path[f - 3]) {
      jerks.add(f, (*path[f] - 3 * *path[f - 1] + 3 * *path[f - 2] - *path[f - 3]).norm());
    }
    if (input.middle[f]) apart.add(f, (*path[f] - *input.middle[f]).norm());
    if (is_outlier(path, f, input.outlier_mm)) ++scores.outliers;
  }
  scores.step_mm = steps.median(key + "step");
  scores.jerk_mm = jerks.median(key + "jerk");
  scores.apart_mm = apart.median(key + "apart");
}

}  // namespace

MeasuredPath path_of(std::span<const FrameReading> readings) {
  MeasuredPath path;
  for (const FrameReading& reading : readings) {
    path.push_back(reading.contacts.empty() ? std::nullopt
                                            : std::optional(reading.contacts.front().place_mm));
  }
  return path;
}

MeasuredPath middle_path(std::span<const MeasuredPath> paths) {
  MeasuredPath out(paths.empty() ? 0 : paths.front().size());
  for (std::size_t f = 0; f < out.size(); ++f) {
    std::vector<Vector2d> places;
    for (const MeasuredPath& path : paths) {
      if (path[f]) places.push_back(*path[f]);
    }
    if (places.size() >= 2) out[f] = middle_of(places);
  }
  return out;
}

ConsistencyScores consistency_scores(const ConsistencyInput& input, const std::string& key) {
  ConsistencyScores scores;
  scores.frames = input.moving.size();
  FrameValues radii(scores.frames);
  FrameValues amplitudes(scores.frames);
  FrameValues peaks(scores.frames);
  FrameValues more(scores.frames);
  FrameValues explained(scores.frames);
  for (std::size_t f = 0; f < scores.frames; ++f) {
    const FrameReading& reading = input.moving[f];
    if (reading.sum) amplitudes.add(f, *reading.sum);
    if (reading.peak) peaks.add(f, *reading.peak);
    if (reading.explained) explained.add(f, *reading.explained);
    if (reading.contacts.empty()) continue;
    ++scores.seen;
    radii.add(f, std::sqrt(reading.contacts.front().area_mm2 / std::numbers::pi));
    more.add(f, static_cast<double>(reading.contacts.size() - 1));
  }
  scores.radius_mm = radii.median(key + "radius");
  scores.radius_spread = radii.spread(key + "radius spread");
  scores.amplitude_spread = amplitudes.spread(key + "amplitude spread");
  scores.peak_spread = peaks.spread(key + "peak spread");
  scores.more_contacts = more.mean(key + "more");
  scores.explained = explained.mean(key + "explained");
  score_path(path_of(input.moving), input, key, scores);
  scores.empty_frames = input.empty.size();
  for (const FrameReading& reading : input.empty) {
    if (!reading.contacts.empty()) ++scores.false_contacts;
  }
  return scores;
}

namespace {

using nlohmann::json;

ConsistentSet consistent_set(const StudyInput& input, const std::string& name, double outlier_mm) {
  ConsistentSet set;
  set.name = name;
  set.empty = input.spec.roles.at("empty");
  std::vector<MeasuredPath> paths;
  for (const std::string& label : input.labels()) {
    ConsistencyOfSolver& solver = set.solvers.emplace_back();
    solver.label = label;
    solver.latency = input.latency(label);
    const auto* moving = input.readings(label, name);
    if (!moving || !input.readings(label, set.empty)) {
      solver.failure = input.failure(label);
      continue;
    }
    solver.path = path_of(*moving);
    paths.push_back(solver.path);
  }
  const MeasuredPath middle = middle_path(paths);
  for (ConsistencyOfSolver& solver : set.solvers) {
    if (!solver.failure.empty()) continue;
    solver.scores =
        consistency_scores({*input.readings(solver.label, name),
                            *input.readings(solver.label, set.empty), middle, outlier_mm},
                           name + solver.label);
  }
  return set;
}

/// The estimates with the names that summary.json and the data have for them.
std::vector<std::pair<const char*, std::optional<Estimate>>> estimates_of(
    const ConsistencyScores& scores) {
  return {{"radius_mm", scores.radius_mm},
          {"radius_spread", scores.radius_spread},
          {"amplitude_spread", scores.amplitude_spread},
          {"peak_spread", scores.peak_spread},
          {"step_mm", scores.step_mm},
          {"jerk_mm", scores.jerk_mm},
          {"more_contacts", scores.more_contacts},
          {"explained", scores.explained},
          {"apart_mm", scores.apart_mm}};
}

std::string share_of(std::size_t part, std::size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

TableSection table_of(const ConsistentSet& set) {
  TableSection table;
  table.caption = set.name + ": one thing moves; empty frames: " + set.empty;
  table.columns = {{"solver", Align::left},
                   {"frames with a contact"},
                   {"radius, mm"},
                   {"spread of the radius"},
                   {"of the image's sum"},
                   {"of its peak"},
                   {"jerk, mm", Align::right, 1},
                   {"outliers", Align::right, 1},
                   {"more contacts", Align::right, 1},
                   {"explained", Align::right, 1},
                   {"from the middle, mm", Align::right, 1},
                   {"false contacts", Align::right, 1},
                   {"p50, µs", Align::right, 1}};
  for (const ConsistencyOfSolver& solver : set.solvers) {
    std::vector<Cell> row = {solver.label};
    if (!solver.failure.empty()) {
      row.emplace_back(solver.failure);
      row.resize(table.columns.size());
      table.rows.push_back(std::move(row));
      continue;
    }
    const ConsistencyScores& scores = solver.scores;
    row.emplace_back(share_of(scores.seen, scores.frames));
    row.push_back(estimate_cell(scores.radius_mm, 1));
    row.push_back(estimate_cell(scores.radius_spread, 3));
    row.push_back(estimate_cell(scores.amplitude_spread, 3));
    row.push_back(estimate_cell(scores.peak_spread, 3));
    row.push_back(estimate_cell(scores.jerk_mm, 2));
    row.emplace_back(std::to_string(scores.outliers));
    row.push_back(estimate_cell(scores.more_contacts, 2));
    row.push_back(estimate_cell(scores.explained, 3));
    row.push_back(estimate_cell(scores.apart_mm, 1));
    row.emplace_back(share_of(scores.false_contacts, scores.empty_frames));
    row.push_back(
        number_cell(solver.latency ? std::optional(solver.latency->p50_s * 1e6) : std::nullopt, 1));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TableSection data_of(const std::vector<ConsistentSet>& sets) {
  TableSection data;
  data.columns = {{"set", Align::left}, {"solver", Align::left}, {"frames"}, {"seen"}};
  for (const auto& [name, value] : estimates_of({})) {
    for (const Column& column : exact_columns(name)) data.columns.push_back(column);
  }
  data.columns.insert(data.columns.end(), {{"outliers"}, {"empty_frames"}, {"false_contacts"}});
  for (const ConsistentSet& set : sets) {
    for (const ConsistencyOfSolver& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      const ConsistencyScores& scores = solver.scores;
      std::vector<Cell> row = {set.name, solver.label, std::to_string(scores.frames),
                               std::to_string(scores.seen)};
      for (const auto& [name, value] : estimates_of(scores)) {
        for (const Cell& cell : exact_cells(value)) row.push_back(cell);
      }
      row.emplace_back(std::to_string(scores.outliers));
      row.emplace_back(std::to_string(scores.empty_frames));
      row.emplace_back(std::to_string(scores.false_contacts));
      data.rows.push_back(std::move(row));
    }
  }
  return data;
}

}  // namespace

Consistency::Consistency(const StudyInput& input)
    : name_(input.spec.name),
      sensor_(input.experiment.sensor),
      outlier_mm_(input.spec.number("outlier") * 2 * sensor_.sheet->radius() *
                  sensor_.sheet->unit_mm()) {
  for (const std::string& set : input.spec.sets) {
    sets_.push_back(consistent_set(input, set, outlier_mm_));
  }
}

json Consistency::summary() const {
  json out = {{"outlier_mm", outlier_mm_}};
  for (const ConsistentSet& set : sets_) {
    json& one = out["sets"][set.name];
    one = {{"empty", set.empty}};
    for (const ConsistencyOfSolver& solver : set.solvers) {
      json& row = one["solvers"][solver.label];
      if (!solver.failure.empty()) {
        row = {{"failure", solver.failure}};
        continue;
      }
      const ConsistencyScores& scores = solver.scores;
      row = {{"frames", scores.frames},
             {"seen", scores.seen},
             {"outliers", scores.outliers},
             {"empty_frames", scores.empty_frames},
             {"false_contacts", scores.false_contacts}};
      for (const auto& [name, value] : estimates_of(scores)) row[name] = to_json(value);
    }
  }
  return out;
}

std::vector<Headline> Consistency::headlines() const {
  std::vector<Headline> out;
  for (const ConsistentSet& set : sets_) {
    for (const ConsistencyOfSolver& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      out.push_back({solver.label, set.name + ": spread of the radius (of its median)", 3,
                     value_of(solver.scores.radius_spread)});
      out.push_back({solver.label, set.name + ": share of the change explained", 3,
                     value_of(solver.scores.explained)});
    }
  }
  return out;
}

std::vector<ReportSection> Consistency::report(const std::string& title,
                                               const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Consistency: measured frames without a truth";
  section.text =
      "One thing of constant size moves over the sheet, and nobody knows where it is. So what "
      "should be constant is held against itself. Radius: of the disc of the strongest contact's "
      "area. Spread: the range of the middle half of the frames, in normal deviations, over the "
      "median. Jerk: the median third difference of the path. Outliers: places farther than " +
      fixed(outlier_mm_, 1) +
      " mm from the median of the four frames around them. Explained: the share of the voltages' "
      "change that the image's linear response explains, at the best amplitude and with the "
      "sheet's level free. From the middle: the median distance to the median place of all "
      "methods. False contacts: of the frames with nothing on the sheet. Intervals: 95 %, by the "
      "bootstrap over blocks of ten frames.";
  for (const ConsistentSet& set : sets_) {
    section.tables.push_back(table_of(set));
    section.figures.push_back(
        path_figure(set, sensor_, title, folder / (name_ + "_paths_" + set.name)));
  }
  write_study_tables({title, section.text, section.tables, {}, {}}, data_of(sets_), folder, name_);
  return {section};
}

}  // namespace ertbench
