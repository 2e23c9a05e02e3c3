#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "bench/studies/drawing.h"
#include "bench/studies/tracking.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Conditions that differ by one quantity alone.
struct SweepColumn {
  std::string title;  ///< what they share
  bool over_speed = true;
  std::vector<const TrackingCondition*> conditions;  ///< ascending in the quantity

  double x(const TrackingCondition& one) const {
    return over_speed ? one.speed_mm_s : one.frame_rate;
  }
};

/// A column for each frame rate at which several speeds were measured; then for each speed with
/// several frame rates of which one is in no column yet; and for what is left by itself.
std::vector<SweepColumn> sweep_columns(std::span<const TrackingCondition> conditions) {
  std::set<const TrackingCondition*> shown;
  std::set<std::string> noises;
  for (const TrackingCondition& one : conditions) noises.insert(one.noise);

  std::vector<SweepColumn> columns;
  const auto add = [&](bool over_speed, std::size_t least, std::size_t least_new) {
    std::set<std::pair<std::string, double>> shared;
    for (const TrackingCondition& one : conditions) {
      shared.emplace(one.noise, over_speed ? one.frame_rate : one.speed_mm_s);
    }
    for (const auto& [noise, value] : shared) {
      SweepColumn column;
      column.over_speed = over_speed;
      column.title = number_text(value) + (over_speed ? " frames/s" : " mm/s");
      if (noises.size() > 1) column.title += ", " + noise;
      std::size_t fresh = 0;
      for (const TrackingCondition& one : conditions) {
        const double its = over_speed ? one.frame_rate : one.speed_mm_s;
        if (one.noise != noise || its != value) continue;
        column.conditions.push_back(&one);
        if (!shown.contains(&one)) ++fresh;
      }
      if (column.conditions.size() < least || fresh < least_new) continue;
      std::stable_sort(column.conditions.begin(), column.conditions.end(),
                       [&](const auto* a, const auto* b) { return column.x(*a) < column.x(*b); });
      shown.insert(column.conditions.begin(), column.conditions.end());
      columns.push_back(std::move(column));
    }
  };
  add(true, 2, 0);
  add(false, 2, 1);
  add(true, 1, 1);
  return columns;
}

class TrackingSweep {
 public:
  explicit TrackingSweep(std::span<const TrackingCondition> conditions)
      : solvers_(conditions.front().solvers),
        styles_(styles_of(solvers_)),
        columns_(sweep_columns(conditions)),
        width_(std::clamp(700.0 / static_cast<double>(columns_.size()), 190.0, 420.0)),
        legend_(left, picture_width() - 10),
        canvas_(picture_width(), legend_top + legend_height(conditions)) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    for (std::size_t c = 0; c < columns_.size(); ++c) draw_panel(c);
    legend_.draw(canvas_, legend_top);
    canvas_.draw(stem);
  }

 private:
  static constexpr double left = 66;
  static constexpr double top = 62;
  static constexpr double height = 200;
  static constexpr double gap_x = 20;
  static constexpr double legend_top = top + height + 62;

  double picture_width() const {
    return left + static_cast<double>(columns_.size()) * (width_ + gap_x);
  }

  /// Fills the legend, and says how much room it needs.
  double legend_height(std::span<const TrackingCondition> conditions) {
    const auto failed = [&](std::size_t s) {
      return std::all_of(conditions.begin(), conditions.end(), [&](const TrackingCondition& one) {
        return !one.solvers[s].failure.empty();
      });
    };
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      if (!failed(s)) legend_.add({solvers_[s].label, styles_.line(s), styles_.mark(s)});
    }
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      if (!failed(s)) continue;
      legend_.new_line();
      legend_.add({solvers_[s].label + " ✕ " + one_line(solvers_[s].failure, 60)});
    }
    legend_.new_line();
    legend_.add({"vertical bars: 95 % intervals"});
    return legend_.height();
  }

  Axis rms_axis() const {
    Span span;
    for (const SweepColumn& column : columns_) {
      for (const TrackingCondition* one : column.conditions) {
        for (const TrackingOfSolver& solver : one->solvers) {
          if (!solver.scores.rms_mm) continue;
          span.extend(std::max(0.01, solver.scores.rms_mm->ci95.low));
          span.extend(std::max(0.01, solver.scores.rms_mm->ci95.high));
        }
      }
    }
    if (span.empty()) span = {1, 100};
    return Axis::logarithms(log_span(span, 1.2), "RMS distance, mm");
  }

  /// With a tick at each value that was measured.
  Axis quantity_axis(const SweepColumn& column) const {
    const double least = column.x(*column.conditions.front());
    const double most = column.x(*column.conditions.back());
    Axis axis{least / 1.35, most * 1.35, true};
    double taken = -1e9;  // px to which the last tick's text reaches
    for (const TrackingCondition* one : column.conditions) {
      const double value = column.x(*one);
      if (!axis.ticks.empty() && axis.ticks.back().value == value) continue;
      std::string text = number_text(value);
      const double middle = width_ * axis.share(value);
      const double half = text_width(text, 11) / 2 + 2;
      if (middle - half < taken) text.clear();
      if (!text.empty()) taken = middle + half;
      axis.ticks.push_back({value, text});
    }
    axis.title = column.over_speed ? "finger speed, mm/s" : "frames/s";
    return axis;
  }

  /// The errors of all solvers in a column's conditions.
  void draw_panel(std::size_t c) {
    const SweepColumn& column = columns_[c];
    const Box box =
        Box::sized(left + static_cast<double>(c) * (width_ + gap_x), top, width_, height);
    Axis axis = rms_axis();
    if (c > 0) {
      axis.title.clear();
      for (Tick& tick : axis.ticks) tick.text.clear();
    }
    const Axis across = quantity_axis(column);
    Panel panel(canvas_, box, across, axis);
    panel.title(column.title);
    // Between the marks of two solvers, as a part of the axis; all of them stay within its margin.
    const double step = 0.075 / std::max(6.0, static_cast<double>(solvers_.size()) - 1);
    for (std::size_t s = 0; s < solvers_.size(); ++s) {
      Series series;
      for (const TrackingCondition* one : column.conditions) {
        const std::optional<Estimate>& value = one->solvers[s].scores.rms_mm;
        if (!value) continue;
        // A little beside the others, so that marks at one place do not hide each other.
        const double beside = static_cast<double>(s) - (double(solvers_.size()) - 1) / 2;
        const double x = column.x(*one) * std::pow(across.high / across.low, step * beside);
        const auto shown = [&](double at) { return axis.capped(at); };
        series.add(
            x, Estimate{shown(value->value), {shown(value->ci95.low), shown(value->ci95.high)}});
        std::string text = solvers_[s].label;
        text.append(", ").append(number_text(one->speed_mm_s)).append(" mm/s, ");
        text.append(number_text(one->frame_rate)).append(" frames/s\nRMS ");
        text.append(fixed(value->value, 1)).append(" mm, 95 % interval ");
        text.append(fixed(value->ci95.low, 1)).append(" to ").append(fixed(value->ci95.high, 1));
        panel.tooltip(x, shown(value->value), text);
      }
      panel.whiskers(series.whiskers, {styles_.colour(s).towards_white(0.45), 1});
      panel.line(series.points, styles_.line(s));
      panel.marks(series.points, styles_.mark(s));
    }
    panel.draw();
  }

  const std::vector<TrackingOfSolver>& solvers_;  ///< of the first condition
  MethodStyles styles_;
  std::vector<SweepColumn> columns_;
  double width_;  ///< of a panel
  Legend legend_;
  Canvas canvas_;
};

constexpr std::size_t gallery_rows = 6;

/// At most gallery_rows of the characters, evenly chosen of those before the first is repeated; a
/// row for the solvers' failures where there are none.
std::vector<std::size_t> shown_characters(const TrackingCondition& condition) {
  std::vector<std::string> names;
  for (const TrackingOfSolver& solver : condition.solvers) {
    for (const TrackedCharacter& one : solver.characters) {
      if (contains(names, one.name)) break;
      names.push_back(one.name);
    }
    if (!names.empty()) break;
  }
  if (names.empty()) return {0};
  const std::size_t rows = std::min(gallery_rows, names.size());
  std::vector<std::size_t> out;
  for (std::size_t r = 0; r < rows; ++r) {
    out.push_back(rows > 1 ? r * (names.size() - 1) / (rows - 1) : 0);
  }
  return out;
}

constexpr LineStyle written_line{ink::light, 1.2};

MarkStyle dot(const Colour& colour) { return {7, colour, 0.22, 1}; }

/// A character as it was written and tracked, and below it how well.
void draw_character(Canvas& canvas, const Box& box, const TrackedCharacter& character,
                    double size_mm, const std::string& label, const Colour& colour) {
  const double reach = 0.68 * size_mm;
  Panel panel(canvas, box, {-reach, reach}, {-reach, reach});
  for (const Polyline& stroke : character.written) panel.line(points_of(stroke), written_line);
  for (const Polyline& stroke : character.tracked) {
    panel.line(points_of(stroke), {colour, 1.2});
    panel.marks(points_of(stroke), dot(colour));
  }
  panel.draw();
  const std::string rms =
      character.rms_mm ? "RMS " + fixed(*character.rms_mm, 1) + " mm" : "nothing tracked";
  const bool right = character.read_back();
  const std::string read = character.read_as.empty() ? "not read"
                           : right                   ? "read as " + character.read_as
                                                     : "misread as " + character.read_as;
  canvas.text(rms, box.middle(), box.bottom + 9, {.size = 10});
  canvas.text(read, box.middle(), box.bottom + 21,
              {.size = 10, .colour = right ? ink::black : ink::alarm});
  canvas.tooltip(box, label + ", " + character.name + "\n" + rms + "\n" + read);
}

/// A method's label in at most three lines above `box`.
void draw_label(Canvas& canvas, const Box& box, const std::string& label) {
  std::vector<std::string> lines = wrapped(label, characters_in(box.width(), 11));
  if (lines.size() > 3) {
    lines.resize(3);
    lines.back() += "…";
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double up = 13 * (static_cast<double>(lines.size() - i) - 0.5);
    canvas.text(lines[i], box.middle(), box.top - 3 - up, {.size = 11});
  }
}

void draw_gallery(const TrackingCondition& condition, const std::string& heading,
                  const std::filesystem::path& stem) {
  constexpr double left = 14;
  constexpr double top = 74;
  constexpr double gap_x = 10;
  constexpr double gap_y = 36;  // with two lines of words
  const std::vector<std::size_t> rows = shown_characters(condition);
  const MethodStyles styles = styles_of(condition.solvers);
  const auto columns = static_cast<double>(condition.solvers.size());
  const double side = std::clamp(950.0 / columns - gap_x, 104.0, 150.0);
  Canvas canvas(std::max(520.0, left + columns * (side + gap_x)),
                top + static_cast<double>(rows.size()) * (side + gap_y) + 30);
  canvas.title(heading);
  for (std::size_t c = 0; c < condition.solvers.size(); ++c) {
    const TrackingOfSolver& solver = condition.solvers[c];
    const double column = left + static_cast<double>(c) * (side + gap_x);
    draw_label(canvas, Box::sized(column, top, side, side), solver.label);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Box box = Box::sized(column, top + static_cast<double>(r) * (side + gap_y), side, side);
      if (rows[r] < solver.characters.size()) {
        draw_character(canvas, box, solver.characters[rows[r]], condition.size_mm, solver.label,
                       styles.colour(c));
        continue;
      }
      Panel(canvas, box, {}, {}).draw();
      canvas.lines(solver.failure, characters_in(side - 8, 9), box.middle(), box.top + 14,
                   {.size = 9, .colour = ink::alarm});
    }
  }
  Legend legend(left, canvas.width());
  legend.add({"written", written_line});
  legend.add({"tracked, stroke by stroke", LineStyle{ink::black, 1.2}, dot(ink::black)});
  legend.draw(canvas, canvas.height() - 14);
  canvas.draw(stem);
}

}  // namespace

std::vector<StudyFigure> tracking_figures(const TrackingConditions& conditions,
                                          const std::string& law) {
  std::set<std::string> noises;
  for (const TrackingCondition& one : *conditions) noises.insert(one.noise);
  const TrackingCondition& first = conditions->front();
  const std::string what = number_text(first.speed_mm_s) + " mm/s, " +
                           number_text(first.frame_rate) + " frames/s, " + first.noise + ", " +
                           law + " law";
  return {{"", "Error",
           "RMS distance of the place known at a moment from the finger by speed and frame rate, " +
               joined(noises, " and ") + ", " + law + " law",
           ", " + law + " law",
           [conditions](const auto& heading, const auto& stem) {
             TrackingSweep(*conditions).draw(heading, stem);
           }},
          {"_characters", "Written and tracked characters: " + first.set,
           what + "; below each its RMS distance, delay and all, and what it was read as",
           ": " + what, [conditions](const auto& heading, const auto& stem) {
             draw_gallery(conditions->front(), heading, stem);
           }}};
}

}  // namespace ertbench
