#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench/ladder/ladder_results.h"
#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/table/table.h"
#include "core/files.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr double panels_left = 70;  ///< of the first panel: names of the upright axes stand there
constexpr double right_edge = 20;   ///< right of the last panel
constexpr double between = 24;      ///< columns
constexpr double share_top = 44, share_bottom = 244;
constexpr double error_top = 270, error_bottom = 490;
constexpr double legend_top = 556;
/// More curves per column cannot be distinguished; further solvers get further columns.
constexpr std::size_t most_curves = 7;

constexpr LineStyle limit_line{ink::dark, 1.2, 3};

struct Series {
  std::string label;
  const LadderClimb* climb = nullptr;
  LineStyle line;
  MarkStyle mark;
};

std::vector<Series> series_of(const LadderAxis& axis, const std::vector<LadderOutcome>& outcomes) {
  std::vector<std::string> labels;
  for (const LadderOutcome& outcome : outcomes) labels.push_back(outcome.entry->label);
  const MethodStyles styles(labels);
  std::vector<Series> out;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const LadderClimb* climb = outcomes[i].record ? outcomes[i].record->find(axis.name) : nullptr;
    if (climb) out.push_back({labels[i], climb, styles.line(i), styles.mark(i, 0.7)});
  }
  return out;
}

/// The levels, from the mildest on the left.
class LevelAxis {
 public:
  /// `series` stand beside each other in a panel `width` px wide.
  LevelAxis(const LadderAxis& axis, std::size_t series, double width)
      : axis_(axis), series_(series), width_(width) {
    first_ = of_file(0);
    last_ = of_file(axis.levels.size() - 1);
    const double range = scaled(last_) - scaled(first_);
    constexpr double margin = 0.04;
    low_ = axis.categories ? -0.5 : unscaled(scaled(first_) - margin * range);
    high_ = axis.categories ? last_ + 0.5 : unscaled(scaled(last_) + margin * range);
  }

  /// Position of a level: its value, or its index for categories.
  double place(const LadderClimb& climb, std::size_t level, std::size_t series) const {
    if (!axis_.categories) return climb.levels[level].level.number();
    return static_cast<double>(level) + 0.6 * beside(series);
  }
  /// Position of a series' whiskers, shifted a little so that they do not hide each other.
  double place_of_whisker(const LadderClimb& climb, std::size_t level, std::size_t series) const {
    const double x = place(climb, level, series);
    if (axis_.categories) return x;
    constexpr double all = 0.018;  // of the axis
    return unscaled(scaled(x) + all * (scaled(last_) - scaled(first_)) * beside(series));
  }

  /// The axis with or without the levels' names, which only the lowest panel has.
  Axis axis(bool names) const {
    Axis out{low_, high_, axis_.logarithmic};
    out.slanted = axis_.levels.size() > 12;
    double taken = -1e9;  // px to which the last name reaches
    for (std::size_t i = 0; i < axis_.levels.size(); ++i) {
      std::string text = names ? one_line(axis_.levels[i].text(), 16) : "";
      const double half = out.slanted ? 9 : text_width(text, 11) / 2 + 1;
      const double middle = width_ * out.share(of_file(i));
      if (middle - half < taken) text.clear();
      if (!text.empty()) taken = middle + half;
      out.ticks.push_back({of_file(i), text});
    }
    if (names) out.title = axis_.unit.empty() ? "level" : "level (" + axis_.unit + ")";
    return out;
  }

  /// True if the experiment names the level; the others are steps of the bisection.
  bool named(const LadderLevel& level) const {
    return std::ranges::find(axis_.levels, level.level) != axis_.levels.end();
  }

 private:
  /// -1/2 ... 1/2 from the first to the last of the series.
  double beside(std::size_t series) const {
    const double middle = (static_cast<double>(series_) - 1) / 2;
    return (static_cast<double>(series) - middle) / static_cast<double>(series_);
  }
  double scaled(double x) const { return axis_.logarithmic ? std::log(x) : x; }
  double unscaled(double x) const { return axis_.logarithmic ? std::exp(x) : x; }
  double of_file(std::size_t i) const {
    return axis_.categories ? static_cast<double>(i) : axis_.levels[i].number();
  }

  const LadderAxis& axis_;
  std::size_t series_;
  double width_;
  double first_ = 0;
  double last_ = 1;
  double low_ = 0;
  double high_ = 1;
};

/// A column of two panels for some of the series, with its legend.
struct PanelColumn {
  std::size_t first;  ///< series
  std::size_t count;
  double left;
  double right;
  LevelAxis levels;
  Legend legend;
};

class LadderDrawing {
 public:
  LadderDrawing(const Ladders& ladders, const LadderAxis& axis,
                const std::vector<LadderOutcome>& outcomes)
      : ladders_(ladders),
        axis_(axis),
        series_(series_of(axis, outcomes)),
        columns_(columns()),
        canvas_(columns_.back().right + right_edge, legend_top + legend_height()) {
    const bool any = std::ranges::any_of(series_, [](const Series& series) {
      const auto& levels = series.climb->levels;
      return std::ranges::any_of(levels, [](const LadderLevel& level) {
        return quantiles(level, &JudgedFrame::error).has_value();
      });
    });
    value_ = any ? &JudgedFrame::error : &JudgedFrame::peak;
  }

  void draw(const std::filesystem::path& stem) {
    canvas_.title(axis_.title);
    for (const PanelColumn& column : columns_) {
      shares(column);
      errors(column);
      column.legend.draw(canvas_, legend_top);
    }
    canvas_.draw(stem);
  }

 private:
  std::vector<PanelColumn> columns() const {
    const std::size_t count =
        std::max<std::size_t>(1, (series_.size() + most_curves - 1) / most_curves);
    const std::size_t each = (series_.size() + count - 1) / count;
    const double panel_width = count == 1 ? 670 : count == 2 ? 440 : 300;
    const int legend_columns = count == 1 ? 3 : count == 2 ? 2 : 1;
    std::vector<PanelColumn> out;
    for (std::size_t c = 0; c < count; ++c) {
      const double left = panels_left + static_cast<double>(c) * (panel_width + between);
      const std::size_t first = c * each;
      const std::size_t here = std::min(each, series_.size() - first);
      PanelColumn column{first,
                         here,
                         left,
                         left + panel_width,
                         LevelAxis(axis_, here, panel_width),
                         Legend(left - 20, left + panel_width + 15, legend_columns)};
      for (std::size_t s = first; s < first + here; ++s) {
        column.legend.add({series_[s].label, series_[s].line, series_[s].mark});
      }
      if (c == 0) column.legend.add({"limits; curves: medians, whiskers: 5 to 95 %", limit_line});
      out.push_back(std::move(column));
    }
    return out;
  }

  double legend_height() const {
    double height = 0;
    for (const PanelColumn& column : columns_) height = std::max(height, column.legend.height());
    return height;
  }

  /// The vertical axis, which only the first column labels.
  static Axis upright(Axis axis, const PanelColumn& column) {
    if (column.first == 0) return axis;
    axis.title.clear();
    for (auto& tick : axis.ticks) tick.text.clear();
    return axis;
  }

  void shares(const PanelColumn& column) {
    Axis axis{-2, 102, false, {}, "failing frames (%)"};
    for (int percent = 0; percent <= 100; percent += 25) {
      axis.ticks.push_back({double(percent), std::to_string(percent)});
    }
    Panel panel(canvas_, {column.left, share_top, column.right, share_bottom},
                column.levels.axis(false), upright(axis, column));
    panel.level(100 * ladders_.failure.share, limit_line);
    for (std::size_t s = 0; s < column.count; ++s) {
      add(panel, column, s,
          [](const LadderLevel& level) { return std::optional(100 * level.share()); });
    }
    panel.draw();
  }

  void errors(const PanelColumn& column) {
    const Axis axis = error_axis();
    Panel panel(canvas_, {column.left, error_top, column.right, error_bottom},
                column.levels.axis(true), upright(axis, column));
    panel.level(limit(), limit_line);
    for (std::size_t s = 0; s < column.count; ++s) {
      add_whiskers(panel, column, s, axis);
      add(panel, column, s, [&](const LadderLevel& level) {
        const auto found = quantiles(level, value_);
        return found ? std::optional(axis.capped(found->median)) : std::nullopt;
      });
    }
    panel.draw();
  }

  /// The curve of a column's series, and marks at the levels that the file names.
  template <typename Value>
  void add(Panel& panel, const PanelColumn& column, std::size_t s, const Value& value_of) {
    const Series& series = series_[column.first + s];
    Points line;
    Points marks;
    for (std::size_t i = 0; i < series.climb->levels.size(); ++i) {
      const LadderLevel& level = series.climb->levels[i];
      const std::optional<double> value = value_of(level);
      if (!value) continue;
      const double x = column.levels.place(*series.climb, i, s);
      line.emplace_back(x, *value);
      if (!column.levels.named(level)) continue;
      marks.emplace_back(x, *value);
      panel.tooltip(x, *value, description(series, level));
    }
    if (!axis_.categories) panel.line(line, series.line);
    panel.marks(marks, series.mark);
  }

  void add_whiskers(Panel& panel, const PanelColumn& column, std::size_t s,
                    const Axis& axis) const {
    const Series& series = series_[column.first + s];
    std::vector<Whisker> whiskers;
    for (std::size_t i = 0; i < series.climb->levels.size(); ++i) {
      const LadderLevel& level = series.climb->levels[i];
      const auto found = quantiles(level, value_);
      if (!found || !column.levels.named(level)) continue;
      whiskers.push_back({column.levels.place_of_whisker(*series.climb, i, s),
                          axis.capped(found->low), axis.capped(found->high)});
    }
    panel.whiskers(whiskers, {series.line.colour.towards_white(0.45), 1});
  }

  /// Covers all medians and whiskers up to ten times the limit.
  Axis error_axis() const {
    Span span{limit(), limit()};
    for (const Series& series : series_) {
      for (const LadderLevel& level : series.climb->levels) {
        if (const auto found = quantiles(level, value_)) {
          span.extend(found->low);
          span.extend(found->high);
        }
      }
    }
    const double most = 10 * limit();
    const bool capped = span.high > most;
    span = {std::max(span.low / 1.15, 0.01 * limit()), std::min(span.high * 1.15, most)};
    Axis axis =
        Axis::logarithms(span, blank() ? "largest change / background" : "relative error of δσ");
    if (capped) axis.cap();
    return axis;
  }

  /// True if no frame has an error because none has a contact; the changes are shown then.
  bool blank() const { return value_ == &JudgedFrame::peak; }
  double limit() const {
    return blank() ? ladders_.failure.contact_threshold : ladders_.failure.relative_error;
  }

  std::string description(const Series& series, const LadderLevel& level) const {
    const auto errors = quantiles(level, value_);
    std::string text = series.label + ", " + level.level.text() + " " + axis_.unit + "\n" +
                       fixed(100 * level.share(), 1) + " % fail";
    if (errors) {
      text += (blank() ? "\nlargest change " : "\nerror ") + three_digits(errors->median) + " (" +
              three_digits(errors->low) + " … " + three_digits(errors->high) + ")";
    }
    return text;
  }

  const Ladders& ladders_;
  const LadderAxis& axis_;
  std::vector<Series> series_;
  std::vector<PanelColumn> columns_;
  std::optional<double> JudgedFrame::*value_ = &JudgedFrame::error;  ///< of the lower panel
  Canvas canvas_;
};

}  // namespace

void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem) {
  LadderDrawing(ladders, axis, outcomes).draw(stem);
}

std::vector<ReportSection> write_ladder_results(const Experiment& experiment,
                                                const std::vector<LadderOutcome>& outcomes,
                                                const Builds& builds,
                                                const std::filesystem::path& folder) {
  if (!experiment.ladders) return {};
  const Ladders& ladders = *experiment.ladders;
  const std::vector<AxisBreakdown> breakdowns = breakdowns_of(ladders, outcomes);
  const std::string title = experiment.title + ": where it fails";
  Table breakdown = breakdown_table(title, ladders, breakdowns);
  if (!builds.empty()) breakdown.legend.push_back(text_of(builds));
  write_file_atomically(folder / "breakdown.csv", csv_of(breakdown_data(breakdowns)));
  write_file_atomically(folder / "breakdown.md", markdown_of(breakdown));
  std::printf("%s\n", terminal_of({"Where it fails:", "", breakdown.sections, {}, ""}).c_str());
  write_file_atomically(folder / "levels.csv", csv_of(levels_data(outcomes)));
  const std::vector<AxisDetection> detections = detections_of(outcomes);
  const Table detected =
      detection_table(experiment.title + ": does it say so?", ladders, detections);
  write_file_atomically(folder / "detection.csv", csv_of(detection_data(detections)));
  write_file_atomically(folder / "detection.md", markdown_of(detected));

  ReportSection table;
  table.title = "Where it fails";
  table.text = "All levels are variants of the test set " + ladders.dataset +
               ", one condition made worse at a time; every solver sees the same frames. The same "
               "numbers are in breakdown.csv, every level in levels.csv.";
  if (const auto map = ladder_map_of(title, breakdowns)) {
    const bool drawn =
        draw_or_say(folder / "breakdown", [&] { draw_heat_map(*map, folder / "breakdown"); });
    table.figures.push_back({"Where each solver fails", folder / "breakdown.svg",
                             "dark: early on the ladder; light: late or never", drawn});
  }
  table.tables = breakdown.sections;
  table.notes = breakdown.legend;

  ReportSection detection;
  detection.title = "Does it say so?";
  detection.text =
      "Share of the failing frames that the solver itself reports as suspect, not converged or "
      "undefined; and of those that do not fail, how many it reports so all the same. The same "
      "numbers are in detection.csv.";
  detection.tables = detected.sections;
  detection.notes = detected.legend;

  ReportSection charts;
  charts.title = "Failures and errors over the level";
  for (const LadderAxis& axis : ladders.axes) {
    const bool climbed = std::ranges::any_of(outcomes, [&](const auto& outcome) {
      return outcome.record && outcome.record->find(axis.name);
    });
    if (!climbed) continue;
    const std::string name = "ladder_" + axis.name;
    const bool drawn = draw_or_say(
        folder / name, [&] { draw_ladder_chart(ladders, axis, outcomes, folder / name); });
    charts.figures.push_back({axis.title, folder / (name + ".svg"),
                              "failing frames and relative error, mildest level on the left",
                              drawn});
  }
  std::vector<ReportSection> sections = {table, detection};
  if (!charts.figures.empty()) sections.push_back(charts);
  return sections;
}

}  // namespace ertbench
