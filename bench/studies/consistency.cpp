#include "bench/studies/consistency.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "bench/studies/columns.h"
#include "bench/studies/drawing.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

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

struct ConsistencyOfSolver {
  std::string label;
  std::string failure;  ///< why there is nothing; else empty
  MeasuredPath path;
  ConsistencyScores scores;
};

/// One test set of frames in which one thing moves.
struct ConsistentSet {
  std::string name;
  std::string empty;  ///< the test set of frames without anything
  std::vector<ConsistencyOfSolver> solvers;
};

ConsistentSet consistent_set(const StudyInput& input, const std::string& name, double outlier_mm) {
  ConsistentSet set;
  set.name = name;
  set.empty = input.spec.roles.at("empty");
  std::vector<MeasuredPath> paths;
  for (const std::string& label : input.labels()) {
    ConsistencyOfSolver& solver = set.solvers.emplace_back();
    solver.label = label;
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
    solver.scores.latency_s = input.latency_s(solver.label);
  }
  return set;
}

std::string share_of(std::size_t part, std::size_t whole) {
  return std::to_string(part) + " of " + std::to_string(whole);
}

using Scores = ConsistencyScores;
using ScoreColumn = StudyColumn<Scores>;

StudyColumns<Scores> score_columns(const std::string& set) {
  const auto headline = [set](const char* what) {
    return [text = set + ": " + what](const Scores&) { return text; };
  };
  return {
      ScoreColumn::count("frames", &Scores::frames),
      ScoreColumn::count("seen", &Scores::seen)
          .table("frames with a contact")
          .shown([](const Scores& s) { return share_of(s.seen, s.frames); }),
      ScoreColumn::estimate("radius_mm", &Scores::radius_mm, 1).table("radius, mm"),
      ScoreColumn::estimate("radius_spread", &Scores::radius_spread, 3)
          .table("spread of the radius")
          .headline(headline("spread of the radius (of its median)"), 3),
      ScoreColumn::estimate("amplitude_spread", &Scores::amplitude_spread, 3)
          .table("of the image's sum"),
      ScoreColumn::estimate("peak_spread", &Scores::peak_spread, 3).table("of its peak"),
      ScoreColumn::estimate("step_mm", &Scores::step_mm, 2),
      ScoreColumn::estimate("jerk_mm", &Scores::jerk_mm, 2).table("jerk, mm", 1),
      ScoreColumn::count("outliers", &Scores::outliers).data("").table("outliers", 1),
      ScoreColumn::estimate("more_contacts", &Scores::more_contacts, 2).table("more contacts", 1),
      ScoreColumn::estimate("explained", &Scores::explained, 3)
          .table("explained", 1)
          .headline(headline("share of the change explained"), 3),
      ScoreColumn::estimate("apart_mm", &Scores::apart_mm, 1).table("from the middle, mm", 1),
      ScoreColumn::count("outliers", &Scores::outliers).data_only(),
      ScoreColumn::count("empty_frames", &Scores::empty_frames),
      ScoreColumn::count("false_contacts", &Scores::false_contacts)
          .table("false contacts", 1)
          .shown([](const Scores& s) { return share_of(s.false_contacts, s.empty_frames); }),
      ScoreColumn::number(
          "",
          [](const Scores& s) {
            return s.latency_s ? std::optional(*s.latency_s * 1e6) : std::nullopt;
          },
          1)
          .table("p50, µs", 1)};
}

/// Adds the set's table, CSV rows, headlines and numbers.
void add_set(const ConsistentSet& set, TableSection& rows, Study& study) {
  const StudyColumns<Scores> columns = score_columns(set.name);
  TableSection& table = study.sections.front().report.tables.emplace_back();
  table.caption = set.name + ": one thing moves; empty frames: " + set.empty;
  table.columns = columns.titles({{"solver", Align::left}});
  rows.columns = columns.names({{"set", Align::left}, {"solver", Align::left}});
  json& numbers = study.numbers["sets"][set.name] = {{"empty", set.empty}};
  for (const ConsistencyOfSolver& solver : set.solvers) {
    if (add_failed(solver.label, solver.failure, table)) {
      numbers["solvers"][solver.label] = {{"failure", solver.failure}};
      continue;
    }
    table.rows.push_back(columns.cells({solver.label}, solver.scores));
    rows.rows.push_back(columns.data({set.name, solver.label}, solver.scores));
    columns.add_headlines(solver.label, solver.scores, study.best);
    numbers["solvers"][solver.label] = columns.json(solver.scores);
  }
}

/// The sheet's border as a closed line, mm.
std::vector<Vector2d> border_mm(const Sheet& sheet, int points) {
  std::vector<Vector2d> out;
  for (int i = 0; i <= points; ++i) {
    out.emplace_back(sheet.unit_mm() * sheet.border_point(sheet.border_length() * i / points));
  }
  return out;
}

std::vector<Vector2d> electrodes_mm(const Sensor& sensor) {
  const Eigen::Matrix2Xd electrodes = electrode_positions(sensor) * sensor.sheet->unit_mm();
  std::vector<Vector2d> out;
  for (const auto& electrode : electrodes.colwise()) out.emplace_back(electrode);
  return out;
}

/// A line through consecutive frames, broken where a frame has no place.
void draw_path(Panel& panel, const MeasuredPath& path, const LineStyle& line,
               const Vector2d& middle) {
  std::vector<Vector2d> piece;
  for (std::size_t f = 0; f <= path.size(); ++f) {
    if (f < path.size() && path[f]) {
      piece.push_back(*path[f]);
    } else if (!piece.empty()) {
      panel.line(points_of(piece, middle), line);
      piece.clear();
    }
  }
}

void draw_paths(const ConsistentSet& set, const Sensor& sensor, const std::string& heading,
                const std::filesystem::path& stem) {
  constexpr double reach = 1.12;  // of the axes, in half sides
  constexpr double width = 460;
  constexpr double left = 64;
  constexpr double top = 44;
  constexpr int points_of_the_border = 120;
  constexpr MarkStyle electrode{5, ink::black, 0.6, 1};
  const Vector2d half = 0.5 * sensor.sheet->size_mm();
  const Vector2d middle = sensor.sheet->bounds().center() * sensor.sheet->unit_mm();
  const MethodStyles styles = styles_of(set.solvers);
  Legend legend(left, left + width);
  const double height = width * half.y() / half.x();
  for (std::size_t s = 0; s < set.solvers.size(); ++s) {
    const ConsistencyOfSolver& solver = set.solvers[s];
    const auto& jerk = solver.scores.jerk_mm;
    legend.add({solver.label + (jerk ? ", jerk " + fixed(jerk->value, 1) + " mm" : std::string()) +
                    (solver.failure.empty() ? "" : ": " + one_line(solver.failure, 40)),
                styles.line(s, 1.4)});
  }
  legend.add({"first frame", {}, styles.mark(0, 0.9)});
  legend.add({"electrode", {}, electrode});
  Canvas canvas(left + width + 24, top + height + 52 + legend.height());
  canvas.title(heading);
  Panel panel(canvas, Box::sized(left, top, width, height),
              Axis::even({-reach * half.x(), reach * half.x()}, "x, mm"),
              Axis::even({-reach * half.y(), reach * half.y()}, "y, mm"));
  panel.line(points_of(border_mm(*sensor.sheet, points_of_the_border), middle), {ink::light, 1});
  panel.marks(points_of(electrodes_mm(sensor), middle), electrode);
  for (std::size_t s = 0; s < set.solvers.size(); ++s) {
    const MeasuredPath& path = set.solvers[s].path;
    draw_path(panel, path, styles.line(s, 1.4), middle);
    const auto first = std::ranges::find_if(path, [](const auto& place) { return bool(place); });
    if (first != path.end()) panel.marks(points_of({**first}, middle), styles.mark(s, 0.9));
  }
  panel.draw();
  legend.draw(canvas, top + height + 50);
  canvas.draw(stem);
}

/// The path that each method saw, on the sheet with its electrodes.
StudyFigure path_figure(const std::shared_ptr<const ConsistentSet>& set, const Sensor& sensor) {
  return {"_paths_" + set->name, "Paths seen in " + set->name,
          "the strongest contact of each frame, from the middle of the sheet",
          ": paths seen, " + set->name, [set, sensor](const auto& heading, const auto& stem) {
            draw_paths(*set, sensor, heading, stem);
          }};
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

Study consistency_study(const StudyInput& input) {
  const Sensor& sensor = input.experiment.sensor;
  const double outlier_mm =
      input.spec.number("outlier") * 2 * sensor.sheet->radius() * sensor.sheet->unit_mm();
  Study study(input.spec.name, "Consistency: measured frames without a truth",
              {{"outlier_mm", outlier_mm}});
  StudySection& section = study.sections.front();
  section.report.text =
      "One thing of constant size moves over the sheet, and nobody knows where it is. So what "
      "should be constant is held against itself. Radius: of the disc of the strongest contact's "
      "area. Spread: the range of the middle half of the frames, in normal deviations, over the "
      "median. Jerk: the median third difference of the path. Outliers: places farther than " +
      fixed(outlier_mm, 1) +
      " mm from the median of the four frames around them. Explained: the share of the voltages' "
      "change that the image's linear response explains, at the best amplitude and with the "
      "sheet's level free. From the middle: the median distance to the median place of all "
      "methods. False contacts: of the frames with nothing on the sheet. Intervals: 95 %, by the "
      "bootstrap over blocks of ten frames.";
  TableSection rows;
  for (const std::string& name : input.spec.sets) {
    const auto set = std::make_shared<ConsistentSet>(consistent_set(input, name, outlier_mm));
    add_set(*set, rows, study);
    section.figures.push_back(path_figure(set, sensor));
  }
  section.data = {{"", rows}};
  return study;
}

}  // namespace ertbench
