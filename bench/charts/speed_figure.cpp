#include "bench/charts/speed_figure.h"

#include <algorithm>
#include <map>
#include <sstream>

#include "bench/analysis/chart_text.h"
#include "bench/charts/speed_panel.h"
#include "bench/plot/canvas.h"
#include "bench/plot/label_layout.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr int width = 1100;
constexpr double top = 66;
constexpr double bottom = 496;
constexpr Box left_box{66, top, 716, bottom};
constexpr Box right_box{786, top, 1080, bottom};
constexpr double legend_top = bottom + 64;
constexpr double legend_line = 19;
constexpr int label_size = 10;

/// gnuplot's filled point types; the hollow one of each stands before it.
constexpr int shapes[] = {7, 5, 9, 11, 13, 15};

class Drawing {
 public:
  Drawing(const SpeedAccuracy& chart, const std::string& title)
      : chart_(chart), title_(title), canvas_(width, height()) {
    for (const SpeedPoint& point : chart.points) {
      if (std::find(types_.begin(), types_.end(), point.type) == types_.end()) {
        types_.push_back(point.type);
      }
    }
  }

  void draw(const std::filesystem::path& stem) {
    const SpeedPanel panels[] = {latency_panel(chart_, left_box), batch_panel(chart_, right_box)};
    canvas_.out() << "set multiplot\nset errorbars small\n";
    for (const SpeedPanel& one : panels) plot(one);
    for (const SpeedPanel& one : panels) write_labels(one);
    canvas_.label(one_line(title_, 150), width / 2.0, 16, 13, "center");
    without_numbers();
    legend();
    canvas_.finish_marks();
    canvas_.out() << "unset multiplot\n";
    canvas_.draw(files_, stem);
  }

 private:
  static int height() { return static_cast<int>(legend_top + 4 * legend_line); }

  std::size_t type_index(const SpeedPoint& point) const {
    return static_cast<std::size_t>(std::find(types_.begin(), types_.end(), point.type) -
                                    types_.begin());
  }
  std::string colour(std::size_t type) const { return "'" + hue(type).hex() + "'"; }
  /// Filled, hollow or a cross.
  int shape(std::size_t type, Standing standing) const {
    if (standing == Standing::failed) return 2;
    return shapes[type % std::size(shapes)] - (standing == Standing::ok ? 0 : 1);
  }

  void plot(const SpeedPanel& panel) {
    const Box& box = panel.box;
    canvas_.area(box.left, box.top, box.right - box.left, box.bottom - box.top);
    std::ostream& out = canvas_.out();
    out << "unset key\nset border 3 linecolor '#606060'\nset logscale x\nset grid xtics ytics "
        << "linetype 1 linecolor '#e4e4e4' linewidth 0.6\nset tics nomirror scale 0.5\n"
        << "set xrange [" << panel.axis.low << ":" << panel.axis.high << "]\nset yrange ["
        << panel.errors.low << ":" << panel.errors.high << "]\nset xtics (" << panel.tics << ")\n"
        << "set ytics autofreq\nset xlabel " << gnuplot_string(panel.x_label) << " offset 0,0.3\n";
    if (!panel.batches) {
      out << "set ylabel " << gnuplot_string("median " + axis_title(chart_.metric))
          << " offset 1,0\n";
    }
    std::string plots;
    add_nothing(panel, plots);
    add_families(panel, plots);
    add_staircase(panel, plots);
    add_marks(panel, plots);
    out << "plot " << plots << "NaN notitle\nunset logscale\nunset grid\nunset xlabel\n"
        << "unset ylabel\nunset border\n";
  }

  void add_nothing(const SpeedPanel& panel, std::string& plots) {
    if (!chart_.nothing || !panel.errors.holds(*chart_.nothing)) return;
    std::ostringstream ends;
    ends << panel.axis.low << ' ' << *chart_.nothing << '\n'
         << panel.axis.high << ' ' << *chart_.nothing << '\n';
    plots += file(ends.str()) + " with lines dashtype 3 linewidth 1 linecolor '#606060', ";
  }

  void add_families(const SpeedPanel& panel, std::string& plots) {
    std::map<std::string, std::pair<std::ostringstream, std::size_t>> lines;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!panel.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      auto& [line, type] = lines[point.family];
      line << *panel.x[i] << ' ' << std::min(*point.error, 3 * panel.errors.high) << '\n';
      type = type_index(point);
    }
    for (const auto& [family, line] : lines) {
      plots += file(line.first.str()) + " with lines linewidth 1.2 linecolor '" +
               hue(line.second).towards_white(0.55).hex() + "', ";
    }
  }

  void add_staircase(const SpeedPanel& panel, std::string& plots) {
    std::ostringstream text;
    for (const auto& [x, error] : staircase(chart_, panel)) text << x << ' ' << error << '\n';
    if (text.str().empty()) return;
    plots += file(text.str()) + " with lines linewidth 1.6 dashtype 2 linecolor '#303030', ";
  }

  void add_marks(const SpeedPanel& panel, std::string& plots) {
    std::map<std::pair<std::size_t, Standing>, std::ostringstream> marks;
    std::ostringstream whiskers;
    std::ostringstream bars;
    std::ostringstream rings;
    std::ostringstream beyond;
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!panel.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      const double x = *panel.x[i];
      if (!panel.errors.holds(*point.error)) {
        beyond.precision(10);  // that of the axis, whose end it is
        beyond << x << ' ' << panel.errors.high << '\n';
        continue;
      }
      marks[{type_index(point), point.standing}] << x << ' ' << *point.error << '\n';
      if (!panel.batches) {
        whiskers << x << ' ' << *point.error << ' ' << x << ' ' << point.latency->p99 << '\n';
      }
      if (point.error_ci95) {
        bars << x << ' ' << *point.error << ' ' << point.error_ci95->low << ' '
             << point.error_ci95->high << '\n';
      }
      if (point.right_size) rings << x << ' ' << *point.error << '\n';
    }
    const auto add = [&](const std::ostringstream& data, const std::string& style) {
      if (const std::string text = data.str(); !text.empty()) plots += file(text) + style + ", ";
    };
    add(whiskers, " with xerrorbars pointtype 0 linewidth 1 linecolor '#909090'");
    add(bars, " with yerrorbars pointtype 0 linewidth 1 linecolor '#909090'");
    for (const auto& [kind, data] : marks) {
      add(data, " with points pointsize 0.9 linewidth 1.4 pointtype " +
                    std::to_string(shape(kind.first, kind.second)) + " linecolor " +
                    colour(kind.first));
    }
    add(rings, " with points pointtype 6 pointsize 1.9 linewidth 1.3 linecolor '#303030'");
    add(beyond, " with points pointtype 2 pointsize 0.9 linewidth 1.4 linecolor '#a00000'");
  }

  void write_labels(const SpeedPanel& panel) {
    const Box& box = panel.box;
    canvas_.label(panel.title, (box.left + box.right) / 2, top - 14, 11, "center");
    std::vector<Box> taken = occupied(chart_, panel);
    if (!panel.batches && chart_.nothing && panel.errors.holds(*chart_.nothing)) {
      const double y = panel.y_of(*chart_.nothing);
      canvas_.label("an image of nothing", box.right - 4, y - 8, 9, "right textcolor '#606060'");
      taken.push_back({box.right - 110, y - 15, box.right, y + 1});
    }
    const std::vector<PointLabel> labels = labels_of(chart_, panel);
    const auto places = place_labels(
        labels, label_size, {box.left + 2, box.top + 2, box.right + 20, box.bottom}, taken);
    for (std::size_t i = 0; i < labels.size(); ++i) {
      if (!places[i]) continue;
      const Box& place = places[i]->box;
      if (places[i]->leader) {
        canvas_.line(labels[i].x, labels[i].y, std::clamp(labels[i].x, place.left, place.right),
                     std::clamp(labels[i].y, place.top, place.bottom),
                     "linewidth 0.6 linecolor '#909090'");
      }
      canvas_.label(labels[i].text, (place.left + place.right) / 2, (place.top + place.bottom) / 2,
                    label_size, "center front");
    }
    for (std::size_t i = 0; i < chart_.points.size(); ++i) {
      if (!panel.shows(chart_, i)) continue;
      const SpeedPoint& point = chart_.points[i];
      canvas_.tooltip_at(panel.x_of(i), panel.y_of(*point.error), description(point, chart_));
    }
  }

  /// Configurations without a place, in the corner where nothing good is.
  void without_numbers() {
    double y = top + 12;
    for (const SpeedPoint& point : chart_.points) {
      if (point.measured()) continue;
      const std::string remark = point.remark.empty() ? "no time" : point.remark;
      canvas_.label("✕ " + one_line(point.label + ": " + remark, 60), left_box.right - 4, y,
                    label_size, "right front textcolor '#a00000'");
      y += label_size + 4;
    }
  }

  void legend() {
    double x = left_box.left;
    double y = legend_top;
    const auto entry = [&](const std::string& mark, const std::string& text) {
      const double long_ = 26 + 6.2 * static_cast<double>(character_count(text));
      if (x + long_ > width - 20) {
        x = left_box.left;
        y += legend_line;
      }
      if (!mark.empty()) {
        canvas_.out() << "set label \"\" at " << canvas_.screen(x + 6, y) << " point " << mark
                      << "\n";
      }
      canvas_.label(text, x + 18, y, label_size, "left");
      x += long_;
    };
    for (std::size_t t = 0; t < types_.size(); ++t) {
      if (types_[t].empty()) continue;
      entry("pointtype " + std::to_string(shape(t, Standing::ok)) +
                " pointsize 0.9 linecolor rgb " + colour(t),
            types_[t]);
    }
    x = width;  // a new line
    entry("pointtype 6 pointsize 0.9 linewidth 1.4 linecolor rgb '#303030'",
          "hollow: over 1 % of the frames not converged; never on the frontier");
    entry("pointtype 2 pointsize 0.9 linewidth 1.4 linecolor rgb '#a00000'",
          "failed, or error beyond the scale");
    x = width;
    canvas_.line(left_box.left, y + legend_line, left_box.left + 14, y + legend_line,
                 "linewidth 1.6 dashtype 2 linecolor '#303030'");
    entry("", "frontier: nothing faster has a smaller error");
    if (!chart_.right_sizes.empty()) {
      entry("pointtype 6 pointsize 1.9 linewidth 1.3 linecolor rgb '#303030'",
            "smallest of its family within " + fixed(100 * chart_.right_sizing->margin, 0) +
                " % of its least validation error");
    }
    entry("", "vertical bar: 95 % interval of the median");
  }

  std::string file(const std::string& text) {
    const std::string name = "points" + std::to_string(files_.size()) + ".txt";
    files_[name] = text;
    return "'" + name + "'";
  }

  const SpeedAccuracy& chart_;
  const std::string& title_;
  std::vector<std::string> types_;
  Canvas canvas_;
  FileContents files_;
};

}  // namespace

void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem) {
  Drawing(chart, title).draw(stem);
}

}  // namespace ertbench
