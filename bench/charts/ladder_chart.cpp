#include "bench/charts/ladder_chart.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/plot/legend.h"
#include "bench/plot/panel.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr int width = 760;
constexpr Box share_box{70, 44, 740, 244};
constexpr Box error_box{70, 270, 740, 490};
constexpr double legend_top = 556;

constexpr LineStyle limit_line{ink::dark, 1.2, 3};

struct Series {
  std::string label;
  const LadderClimb* climb = nullptr;
  std::size_t index = 0;  ///< among all solvers, which sets its colour

  Colour colour() const { return hue(index); }
  LineStyle line() const {
    constexpr int dashes[] = {1, 2, 4, 5, 3};
    return {colour(), 1.3, dashes[index % std::size(dashes)]};
  }
  MarkStyle mark() const {
    const bool again = index / std::size(shapes) % 2 == 1;
    return {again ? hollow(index) : filled(index), colour(), 0.7, 1.2};
  }
};

std::vector<Series> series_of(const LadderAxis& axis, const std::vector<LadderOutcome>& outcomes) {
  std::vector<Series> out;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const LadderClimb* climb = outcomes[i].record ? outcomes[i].record->find(axis.name) : nullptr;
    if (climb) out.push_back({outcomes[i].entry->label, climb, i});
  }
  return out;
}

/// The levels, from the mildest on the left.
class LevelAxis {
 public:
  LevelAxis(const LadderAxis& axis, std::size_t series) : axis_(axis), series_(series) {
    first_ = of_file(0);
    last_ = of_file(axis.levels.size() - 1);
    const double range = scaled(last_) - scaled(first_);
    constexpr double margin = 0.04;
    low_ = axis.categories ? -0.5 : unscaled(scaled(first_) - margin * range);
    high_ = axis.categories ? last_ + 0.5 : unscaled(scaled(last_) + margin * range);
  }

  /// Where a level of the climb lies: categories side by side, others where they are.
  double place(const LadderClimb& climb, std::size_t level, std::size_t series) const {
    if (!axis_.categories) return climb.levels[level].level.number();
    return static_cast<double>(level) + 0.6 * beside(series);
  }
  /// The same of whiskers, which would hide each other: a little beside their marks.
  double place_of_whisker(const LadderClimb& climb, std::size_t level, std::size_t series) const {
    const double x = place(climb, level, series);
    if (axis_.categories) return x;
    constexpr double all = 0.018;  // of the axis
    return unscaled(scaled(x) + all * (scaled(last_) - scaled(first_)) * beside(series));
  }

  /// With the levels' names, or without where another panel below has them.
  Axis axis(bool names) const {
    Axis out{low_, high_, axis_.logarithmic};
    out.slanted = axis_.levels.size() > 12;
    double taken = -1e9;  // px to which the last name reaches
    for (std::size_t i = 0; i < axis_.levels.size(); ++i) {
      std::string text = names ? one_line(axis_.levels[i].text(), 16) : "";
      const double half = out.slanted ? 9 : text_width(text, 11) / 2 + 1;
      const double middle = error_box.width() * out.share(of_file(i));
      if (middle - half < taken) text.clear();
      if (!text.empty()) taken = middle + half;
      out.ticks.push_back({of_file(i), text});
    }
    if (names) out.title = axis_.unit.empty() ? "level" : "level (" + axis_.unit + ")";
    return out;
  }

  /// Whether the file names the level, which is no step of the search between two others.
  bool named(const LadderLevel& level) const {
    return std::find(axis_.levels.begin(), axis_.levels.end(), level.level) != axis_.levels.end();
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
  double first_ = 0;
  double last_ = 1;
  double low_ = 0;
  double high_ = 1;
};

class Drawing {
 public:
  Drawing(const Ladders& ladders, const LadderAxis& axis,
          const std::vector<LadderOutcome>& outcomes)
      : ladders_(ladders),
        axis_(axis),
        series_(series_of(axis, outcomes)),
        levels_(axis, series_.size()),
        legend_(legend()),
        canvas_(width, legend_top + legend_.height()) {
    const bool any = std::any_of(series_.begin(), series_.end(), [](const Series& series) {
      const auto& levels = series.climb->levels;
      return std::any_of(levels.begin(), levels.end(), [](const LadderLevel& level) {
        return quantiles(level, &JudgedFrame::error).has_value();
      });
    });
    value_ = any ? &JudgedFrame::error : &JudgedFrame::peak;
  }

  void draw(const std::filesystem::path& stem) {
    canvas_.title(axis_.title);
    shares();
    errors();
    legend_.draw(canvas_, legend_top);
    canvas_.draw(stem);
  }

 private:
  void shares() {
    Axis axis{-2, 102, false, {}, "failing frames (%)"};
    for (int percent = 0; percent <= 100; percent += 25) {
      axis.ticks.push_back({double(percent), std::to_string(percent)});
    }
    Panel panel(canvas_, share_box, levels_.axis(false), axis);
    panel.level(100 * ladders_.failure.share, limit_line);
    for (std::size_t s = 0; s < series_.size(); ++s) {
      add(panel, s, [](const LadderLevel& level) { return std::optional(100 * level.share()); });
    }
    panel.draw();
  }

  void errors() {
    const Axis axis = error_axis();
    Panel panel(canvas_, error_box, levels_.axis(true), axis);
    panel.level(limit(), limit_line);
    for (std::size_t s = 0; s < series_.size(); ++s) {
      add_whiskers(panel, s, axis);
      add(panel, s, [&](const LadderLevel& level) {
        const auto found = quantiles(level, value_);
        return found ? std::optional(axis.capped(found->median)) : std::nullopt;
      });
    }
    panel.draw();
  }

  /// The curve of a series, and marks at the levels that the file names.
  template <typename Value>
  void add(Panel& panel, std::size_t s, const Value& value_of) {
    const Series& series = series_[s];
    Points line;
    Points marks;
    for (std::size_t i = 0; i < series.climb->levels.size(); ++i) {
      const LadderLevel& level = series.climb->levels[i];
      const std::optional<double> value = value_of(level);
      if (!value) continue;
      const double x = levels_.place(*series.climb, i, s);
      line.emplace_back(x, *value);
      if (!levels_.named(level)) continue;
      marks.emplace_back(x, *value);
      panel.tooltip(x, *value, description(series, level));
    }
    if (!axis_.categories) panel.line(line, series.line());
    panel.marks(marks, series.mark());
  }

  void add_whiskers(Panel& panel, std::size_t s, const Axis& axis) const {
    const Series& series = series_[s];
    std::vector<Whisker> whiskers;
    for (std::size_t i = 0; i < series.climb->levels.size(); ++i) {
      const LadderLevel& level = series.climb->levels[i];
      const auto found = quantiles(level, value_);
      if (!found || !levels_.named(level)) continue;
      whiskers.push_back({levels_.place_of_whisker(*series.climb, i, s), axis.capped(found->low),
                          axis.capped(found->high)});
    }
    panel.whiskers(whiskers, {series.colour().towards_white(0.45), 1});
  }

  /// Around all medians and whiskers; what is ten times worse than the limit need not be told from
  /// what is a hundred times.
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
    Axis axis = Axis::logarithms(span, blank() ? "largest change over c₀" : "relative error of δσ");
    if (capped) axis.cap();
    return axis;
  }

  /// Whether no frame has an error, as none has a contact: then the changes are shown.
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

  Legend legend() const {
    Legend legend(share_box.left - 20, share_box.right + 15, 3);
    for (const Series& series : series_) legend.add({series.label, series.line(), series.mark()});
    legend.add({"limits; whiskers: 5 to 95 %", limit_line});
    return legend;
  }

  const Ladders& ladders_;
  const LadderAxis& axis_;
  std::vector<Series> series_;
  LevelAxis levels_;
  std::optional<double> JudgedFrame::*value_ = &JudgedFrame::error;  ///< of the lower panel
  Legend legend_;
  Canvas canvas_;
};

}  // namespace

void draw_ladder_chart(const Ladders& ladders, const LadderAxis& axis,
                       const std::vector<LadderOutcome>& outcomes,
                       const std::filesystem::path& stem) {
  Drawing(ladders, axis, outcomes).draw(stem);
}

}  // namespace ertbench
