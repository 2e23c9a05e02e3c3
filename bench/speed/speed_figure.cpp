#include "bench/speed/speed_figure.h"

#include <algorithm>
#include <map>

#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/speed/speed_accuracy.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr int width = 1100;
constexpr double top = 66;
constexpr double bottom = 496;
constexpr Box left_box{66, top, 700, bottom};
constexpr Box right_box{768, top, 1080, bottom};
constexpr double legend_top = bottom + 64;

constexpr LineStyle whisker_line{rgb(0x909090), 1};
constexpr LineStyle frontier_line{ink::dark, 1.6, 2};
constexpr LineStyle nothing_line{rgb(0x606060), 1, 3};
constexpr LineStyle limit_line{ink::alarm, 1.4};
const Colour limit_band = ink::alarm.towards_white(0.86);
constexpr double mark_size = 0.9;
constexpr MarkStyle ring{circle, ink::dark, 1.9, 1.3};
constexpr MarkStyle lost{cross, ink::alarm};

class SpeedDrawing {
 public:
  SpeedDrawing(const SpeedAccuracy& chart, const std::string& title)
      : chart_(chart),
        types_(types_of(chart)),
        styles_(types_),
        legend_(legend()),
        canvas_(width, legend_top + legend_.height()) {
    canvas_.title(title);
  }

  void draw(const std::filesystem::path& stem) {
    plot(latency_panel(chart_, left_box));
    plot(batch_panel(chart_, right_box));
    without_numbers();
    legend_.draw(canvas_, legend_top);
    canvas_.draw(stem);
  }

 private:
  static std::vector<std::string> types_of(const SpeedAccuracy& chart) {
    std::vector<std::string> types;
    for (const SpeedPoint& point : chart.points) {
      if (std::find(types.begin(), types.end(), point.type) == types.end()) {
        types.push_back(point.type);
      }
    }
    return types;
  }

  std::size_t type_index(const SpeedPoint& point) const {
    return static_cast<std::size_t>(std::find(types_.begin(), types_.end(), point.type) -
                                    types_.begin());
  }
  MarkStyle mark(std::size_t type, Standing standing) const {
    MarkStyle out = standing == Standing::ok ? styles_.filled_mark(type, mark_size)
                                             : styles_.hollow_mark(type, mark_size);
    if (standing == Standing::failed) out.shape = cross;
    return out;
  }

  void plot(const SpeedPanel& shown) {
    Panel panel(canvas_, shown.box, shown.axis, shown.errors);
    panel.title(shown.title);
    if (chart_.nothing && shown.holds(*chart_.nothing)) panel.level(*chart_.nothing, nothing_line);
    if (chart_.limit) {
      if (chart_.limit_ci95) {
        panel.band(chart_.limit_ci95->low, chart_.limit_ci95->high, limit_band);
      }
      panel.level(*chart_.limit, limit_line);
    }
    const std::vector<FamilyLine> families = family_lines(chart_, shown);
    for (const FamilyLine& line : families) {
      const Colour colour = styles_.colour(type_index(chart_.points[line.first]));
      panel.line(line.points, {colour.towards_white(0.55), 1.2});
    }
    panel.line(staircase(chart_, shown), frontier_line);
    add_whiskers(shown, panel);
    add_marks(shown, panel);
    panel.draw();
    write_labels(shown, panel, segments_of(families, shown));
  }

  void add_whiskers(const SpeedPanel& shown, Panel& panel) const {
    std::vector<Whisker> times;
    std::vector<Whisker> errors;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      const SpeedPoint& point = chart_.points[i];
      if (!shown.shows(chart_, i) || !shown.holds(*point.error)) continue;
      const double x = *shown.x[i];
      if (!shown.batches) times.push_back({*point.error, x, point.latency->p99});
      if (point.error_ci95) errors.push_back({x, point.error_ci95->low, point.error_ci95->high});
    }
    panel.whiskers_across(times, whisker_line);
    panel.whiskers(errors, whisker_line);
  }

  void add_marks(const SpeedPanel& shown, Panel& panel) const {
    std::map<std::pair<std::size_t, Standing>, Points> marks;
    Points rings;
    Points beyond;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!shown.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      if (!shown.holds(*point.error)) {
        beyond.emplace_back(*shown.x[i], shown.errors.high);
        continue;
      }
      marks[{type_index(point), point.standing}].emplace_back(*shown.x[i], *point.error);
      if (point.right_size) rings.emplace_back(*shown.x[i], *point.error);
    }
    for (const auto& [kind, points] : marks) panel.marks(points, mark(kind.first, kind.second));
    panel.marks(rings, ring);
    panel.marks(beyond, lost);
  }

  std::string limit_text() const {
    std::string text = "the limit (median of what is best in the mean), of the first " +
                       std::to_string(chart_.limit_frames) + " frames (band: 95 %)";
    if (chart_.limit_unresolved > 0) {
      text += "; " + std::to_string(chart_.limit_unresolved) + " of them unresolved";
    }
    return text;
  }

  void write_labels(const SpeedPanel& shown, Panel& panel, std::vector<Segment> lines) {
    std::vector<Box> taken = occupied(chart_, shown);
    if (!shown.batches && chart_.nothing && shown.holds(*chart_.nothing)) {
      const double y = shown.y_of(*chart_.nothing);
      canvas_.text("an image of nothing", shown.box.right - 4, y - 8,
                   {.size = 9, .align = TextAlign::right, .colour = nothing_line.colour});
      taken.push_back({shown.box.right - 110, y - 15, shown.box.right, y + 1});
    }
    // Below the limit only its own label may stand: any other would read as better than the limit.
    if (chart_.limit) {
      const double y = shown.y_of(*chart_.limit);
      if (!shown.batches) {
        const bool has_room = shown.box.bottom - y > 16;
        const double text_y = has_room ? y + 8 : y - 8;
        canvas_.text(limit_text(), shown.box.right - 4, text_y,
                     {.size = 9, .align = TextAlign::right, .colour = limit_line.colour});
        taken.push_back({shown.box.right - 490, text_y - 8, shown.box.right, text_y + 8});
      }
      taken.push_back({shown.box.left, y - 2, shown.box.right, shown.box.bottom});
    }
    if (chart_.nothing) {
      const double y = shown.y_of(*chart_.nothing);
      lines.push_back({shown.box.left, y, shown.box.right, y});
    }
    const auto colour_of = [this](const SpeedPoint& point) {
      return styles_.colour(type_index(point)).for_text();
    };
    panel.labels(labels_of(chart_, shown, colour_of), taken, lines);
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!shown.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      canvas_.tooltip_at(shown.x_of(*shown.x[i]), shown.y_of(*point.error),
                         description(point, chart_));
    }
  }

  /// Lists configurations without numbers in the upper right corner, which is empty.
  void without_numbers() {
    constexpr TextStyle style{.align = TextAlign::right, .colour = ink::alarm};
    double y = top + 12;
    for (const SpeedPoint& point : chart_.points) {
      if (point.measured()) continue;
      const std::string remark = point.remark.empty() ? "no time" : point.remark;
      canvas_.text("✕ " + one_line(point.label + ": " + remark, 60), left_box.right - 4, y, style);
      y += style.size + 4;
    }
  }

  Legend legend() const {
    Legend legend(left_box.left, width - 20);
    for (std::size_t t = 0; t < types_.size(); ++t) {
      if (!types_[t].empty()) legend.add({types_[t], {}, mark(t, Standing::ok)});
    }
    legend.new_line();
    legend.add({"hollow: over 1 % of the frames not converged; never on the frontier",
                {},
                MarkStyle{circle, ink::dark}});
    legend.add({"failed, or error beyond the scale", {}, lost});
    legend.new_line();
    legend.add({"frontier: nothing faster has a smaller error", frontier_line});
    if (!chart_.right_sizes.empty()) {
      legend.add({"smallest of its family within " + fixed(100 * chart_.right_sizing->margin, 0) +
                      " % of its least validation error",
                  {},
                  ring});
    }
    legend.add({"vertical bar: 95 % interval of the median"});
    return legend;
  }

  const SpeedAccuracy& chart_;
  std::vector<std::string> types_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
};

}  // namespace

void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem) {
  SpeedDrawing(chart, title).draw(stem);
}

}  // namespace ertbench
