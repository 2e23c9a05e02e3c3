#include "bench/charts/ladder_chart.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bench/plot/axis_ticks.h"
#include "bench/plot/canvas.h"
#include "bench/plot/label_layout.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr int width = 760;
constexpr Box share_box{70, 44, 740, 244};
constexpr Box error_box{70, 270, 740, 490};
constexpr double legend_top = 556;
constexpr double legend_line = 18;
constexpr int legend_columns = 3;

constexpr int shapes[] = {7, 5, 9, 11, 13, 15, 6, 4};
constexpr int dashes[] = {1, 2, 4, 5, 3};

struct Series {
  std::string label;
  const LadderClimb* climb = nullptr;
  std::size_t index = 0;  ///< among all solvers, which sets its colour
};

class Drawing {
 public:
  Drawing(const Ladders& ladders, const LadderAxis& axis,
          const std::vector<LadderOutcome>& outcomes)
      : ladders_(ladders),
        axis_(axis),
        series_(series_of(axis, outcomes)),
        canvas_(width, height()) {
    const bool any = std::any_of(series_.begin(), series_.end(), [](const Series& series) {
      const auto& levels = series.climb->levels;
      return std::any_of(levels.begin(), levels.end(), [](const LadderLevel& level) {
        return quantiles(level, &JudgedFrame::error).has_value();
      });
    });
    value_ = any ? &JudgedFrame::error : &JudgedFrame::peak;
    first_ = x_of_level(0);
    last_ = x_of_level(axis.levels.size() - 1);
    const double margin = 0.04;
    const double range = scaled(last_) - scaled(first_);
    left_ = axis.categories ? -0.5 : unscaled(scaled(first_) - margin * range);
    right_ = axis.categories ? last_ + 0.5 : unscaled(scaled(last_) + margin * range);
  }

  void draw(const std::filesystem::path& stem) {
    canvas_.out() << "set multiplot\nset errorbars small\n";
    shares();
    errors();
    canvas_.label(one_line(axis_.title, 110), width / 2.0, 18, 13, "center");
    legend();
    canvas_.finish_marks();
    canvas_.out() << "unset multiplot\n";
    canvas_.draw(files_, stem);
  }

 private:
  static std::vector<Series> series_of(const LadderAxis& axis,
                                       const std::vector<LadderOutcome>& outcomes) {
    std::vector<Series> out;
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
      const LadderClimb* climb = outcomes[i].record ? outcomes[i].record->find(axis.name) : nullptr;
      if (climb) out.push_back({outcomes[i].entry->label, climb, i});
    }
    return out;
  }

  int height() const {
    const std::size_t entries = series_.size() + 1;
    const std::size_t lines = (entries + legend_columns - 1) / legend_columns;
    return static_cast<int>(legend_top + legend_line * static_cast<double>(lines) + 4);
  }

  double scaled(double x) const { return axis_.logarithmic ? std::log(x) : x; }
  double unscaled(double x) const { return axis_.logarithmic ? std::exp(x) : x; }
  double x_of_level(std::size_t i) const {
    return axis_.categories ? static_cast<double>(i)
                            : nlohmann::json::parse(axis_.levels[i]).get<double>();
  }
  double x_of(const Series& series, std::size_t level) const {
    return axis_.categories ? static_cast<double>(level) : series.climb->levels[level].number();
  }
  /// A little beside the others, so that marks of one level do not hide each other.
  double beside(double x, std::size_t place) const {
    const double step = axis_.categories ? 0.6 / static_cast<double>(series_.size())
                                         : 0.004 * (scaled(last_) - scaled(first_));
    const double middle = (static_cast<double>(series_.size()) - 1) / 2;
    return unscaled(scaled(x) + (static_cast<double>(place) - middle) * step);
  }
  bool is_of_file(const LadderLevel& level) const {
    return std::find(axis_.levels.begin(), axis_.levels.end(), level.level) != axis_.levels.end();
  }

  /// Where a level lies, 0 at the left edge to 1 at the right.
  double across(double x) const {
    return (scaled(x) - scaled(left_)) / (scaled(right_) - scaled(left_));
  }

  std::string colour(const Series& series) const { return "'" + hue(series.index).hex() + "'"; }
  int shape(const Series& series) const { return shapes[series.index % std::size(shapes)]; }
  int dash(const Series& series) const { return dashes[series.index % std::size(dashes)]; }

  void axes(const Box& box, bool lower) {
    canvas_.area(box.left, box.top, box.right - box.left, box.bottom - box.top);
    std::ostream& out = canvas_.out();
    out << "unset key\nset border 3 linecolor '#606060'\nset grid xtics ytics linetype 1 "
           "linecolor '#e4e4e4' linewidth 0.6\nset tics nomirror scale 0.5\nset xrange ["
        << left_ << ":" << right_ << "]\n"
        << (axis_.logarithmic ? "set logscale x\n" : "unset logscale x\n");
    out << "set xtics (";
    const bool many = axis_.levels.size() > 12;
    double taken = -1e9;  // px to which the last label reaches
    for (std::size_t i = 0; i < axis_.levels.size(); ++i) {
      std::string text = lower ? one_line(level_text(axis_.levels[i]), 16) : "";
      const double half = many ? 9 : 3.6 * static_cast<double>(character_count(text));
      const double middle = across(x_of_level(i)) * (box.right - box.left);
      if (middle - half < taken) text.clear();
      if (!text.empty()) taken = middle + half;
      out << (i > 0 ? ", " : "") << gnuplot_string(text) << " " << x_of_level(i);
    }
    out << ")" << (many ? " rotate by 45 right" : " norotate") << "\n";
    const std::string name = axis_.unit.empty() ? "level" : "level (" + axis_.unit + ")";
    out << "set xlabel " << gnuplot_string(lower ? name : "") << " offset 0,0.3\n";
  }

  void shares() {
    axes(share_box, false);
    canvas_.out() << "set yrange [-2:102]\nset ytics 0,25,100\nset ylabel "
                  << gnuplot_string("failing frames (%)") << " offset 1,0\n";
    std::string plots = level_line(100 * ladders_.failure.share);
    for (std::size_t s = 0; s < series_.size(); ++s) {
      std::ostringstream line;
      std::ostringstream marks;
      for (std::size_t i = 0; i < series_[s].climb->levels.size(); ++i) {
        const LadderLevel& level = series_[s].climb->levels[i];
        const double x = x_of(series_[s], i);
        line << x << ' ' << 100 * level.share() << '\n';
        if (!is_of_file(level)) continue;
        marks << beside(x, s) << ' ' << 100 * level.share() << '\n';
        tooltip(share_box, beside(x, s), 1 - (100 * level.share() + 2) / 104, series_[s], level);
      }
      if (!axis_.categories) plots += curve(series_[s], line.str());
      plots += points(series_[s], marks.str());
    }
    plot(plots);
  }

  void errors() {
    const double limit =
        blank() ? ladders_.failure.contact_threshold : ladders_.failure.relative_error;
    double low = limit;
    double high = limit;
    for (const Series& series : series_) {
      for (const LadderLevel& level : series.climb->levels) {
        const auto found = quantiles(level, value_);
        if (!found) continue;
        low = std::min(low, found->low);
        high = std::max(high, found->high);
      }
    }
    // What is ten times worse than nothing need not be told from what is a hundred times.
    low = std::max(low / 1.15, 0.01 * limit);
    high = std::min(high * 1.15, 10 * limit);
    axes(error_box, true);
    canvas_.out() << "set logscale y\nset yrange [" << low << ":" << high << "]\nset ytics ("
                  << tick_list(log_ticks({low, high})) << ")\nset ylabel "
                  << gnuplot_string(blank() ? "largest change over c₀" : "relative error of δσ")
                  << " offset 1,0\n";
    std::string plots = level_line(limit);
    for (std::size_t s = 0; s < series_.size(); ++s) {
      std::ostringstream line;
      std::ostringstream marks;
      std::ostringstream whiskers;
      for (std::size_t i = 0; i < series_[s].climb->levels.size(); ++i) {
        const LadderLevel& level = series_[s].climb->levels[i];
        const auto found = quantiles(level, value_);
        if (!found) continue;
        const double x = x_of(series_[s], i);
        const double y = std::min(found->median, high);
        line << x << ' ' << y << '\n';
        if (!is_of_file(level)) continue;
        marks << beside(x, s) << ' ' << y << '\n';
        whiskers << beside(x, s) << ' ' << y << ' ' << std::max(found->low, low) << ' '
                 << std::min(found->high, high) << '\n';
        tooltip(error_box, beside(x, s), std::log(high / y) / std::log(high / low), series_[s],
                level);
      }
      if (!whiskers.str().empty()) {
        plots += file(whiskers.str()) + " with yerrorbars pointtype 0 linewidth 1 linecolor '" +
                 hue(series_[s].index).towards_white(0.45).hex() + "', ";
      }
      if (!axis_.categories) plots += curve(series_[s], line.str());
      plots += points(series_[s], marks.str());
    }
    plot(plots);
    canvas_.out() << "unset logscale\n";
  }

  /// Whether no frame has an error, as none has a contact: then the changes are shown.
  bool blank() const { return value_ == &JudgedFrame::peak; }

  std::string level_line(double y) {
    std::ostringstream ends;
    ends.precision(10);
    ends << left_ << ' ' << y << '\n' << right_ << ' ' << y << '\n';
    return file(ends.str()) + " with lines dashtype 3 linewidth 1.2 linecolor '#303030', ";
  }
  std::string curve(const Series& series, const std::string& data) {
    if (data.empty()) return "";
    return file(data) + " with lines linewidth 1.3 dashtype " + std::to_string(dash(series)) +
           " linecolor " + colour(series) + ", ";
  }
  std::string points(const Series& series, const std::string& data) {
    if (data.empty()) return "";
    return file(data) + " with points pointsize 0.7 linewidth 1.2 pointtype " +
           std::to_string(shape(series)) + " linecolor " + colour(series) + ", ";
  }
  void plot(const std::string& plots) {
    canvas_.out() << "plot " << plots << "NaN notitle\nunset grid\nunset xlabel\nunset ylabel\n";
  }

  void tooltip(const Box& box, double x, double down, const Series& series,
               const LadderLevel& level) {
    const auto errors = quantiles(level, value_);
    std::string text = series.label + ", " + level_text(level.level) + " " + axis_.unit + "\n" +
                       fixed(100 * level.share(), 1) + " % fail";
    if (errors) {
      text += (blank() ? "\nlargest change " : "\nerror ") + three_digits(errors->median) + " (" +
              three_digits(errors->low) + " … " + three_digits(errors->high) + ")";
    }
    canvas_.tooltip_at(box.left + across(x) * (box.right - box.left),
                       box.top + down * (box.bottom - box.top), text);
  }

  void legend() {
    std::size_t entry = 0;
    const auto place = [&] {
      const std::size_t at = entry++;
      return std::pair(share_box.left - 20 + static_cast<double>(at % legend_columns) * 235,
                       legend_top + legend_line * static_cast<double>(at / legend_columns));
    };
    for (const Series& series : series_) {
      const auto [x, y] = place();
      canvas_.line(x, y, x + 34, y,
                   "linewidth 1.3 dashtype " + std::to_string(dash(series)) + " linecolor rgb " +
                       colour(series));
      canvas_.out() << "set label \"\" at " << canvas_.screen(x + 17, y) << " point pointtype "
                    << shape(series) << " pointsize 0.8 linecolor rgb " << colour(series) << "\n";
      canvas_.label(one_line(series.label, 30), x + 41, y, 10, "left");
    }
    const auto [x, y] = place();
    canvas_.line(x, y, x + 34, y, "linewidth 1.2 dashtype 3 linecolor rgb '#303030'");
    canvas_.label("limits; whiskers: 5 to 95 %", x + 41, y, 10, "left");
  }

  std::string file(const std::string& text) {
    const std::string name = "points" + std::to_string(files_.size()) + ".txt";
    files_[name] = text;
    return "'" + name + "'";
  }

  const Ladders& ladders_;
  const LadderAxis& axis_;
  std::vector<Series> series_;
  std::optional<double> JudgedFrame::*value_ = &JudgedFrame::error;  ///< of the lower panel
  double first_ = 0;
  double last_ = 1;
  double left_ = 0;
  double right_ = 1;
  Canvas canvas_;
  FileContents files_;
};

}  // namespace

void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem) {
  Drawing(ladders, axis, outcomes).draw(stem);
}

}  // namespace ertbench
