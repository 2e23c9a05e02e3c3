#include "bench/report/bar_chart.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "bench/experiment/experiment_charts.h"
#include "bench/plot/panel.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// What stands below the bars.
std::vector<std::string> captions(const Bars& bars) {
  std::vector<std::string> out = bars.labels;
  for (std::size_t v = 0; v < out.size(); ++v) {
    if (!bars.statuses[v].empty()) out[v] += " (" + bars.statuses[v] + ")";
  }
  return out;
}

/// Of a panel, px: a slot holds the widest word, unless that makes the panel too wide.
double panel_width(const Bars& bars) {
  constexpr double least_slot = 46;
  constexpr double widest = 640;
  double slot = least_slot;
  for (const std::string& name : captions(bars)) slot = std::max(slot, widest_word(name, 9) + 6);
  const auto variants = static_cast<double>(bars.labels.size());
  if (slot * variants > widest) return std::clamp(variants * 22, 380.0, 1200.0);
  return std::max(300.0, slot * variants);
}

/// Places and sizes in px.
struct BarLayout {
  int variants;
  int panels;
  double width;         ///< of a panel
  double names_height;  ///< below each panel

  static constexpr double left = 64;
  static constexpr double top = 34;
  static constexpr double title = 26;
  static constexpr double height = 170;  ///< of a panel
  static constexpr double right = 14;
  static constexpr double note = 20;

  int columns() const { return std::min(panels, 2); }
  double slot() const { return width / variants; }
  /// Whether a value is too wide for its bar.
  bool narrow() const { return slot() < 40; }
  double row_height() const { return title + height + names_height + 10; }
  double picture_width() const { return columns() * (left + width) + right; }
  double picture_height() const { return top + (panels + 1) / 2 * row_height() + note; }
  Box box(int panel) const {
    return Box::sized(left + panel % columns() * (left + width),
                      top + panel / columns() * row_height() + title, width, height);
  }
};

/// Whether bars from zero would hide what the panel is about: all values, their whiskers and the
/// ideal lie in a small part of the way up from zero. They are drawn as points then, on an axis
/// that begins where they do.
bool far_from_zero(const BarPanel& panel) {
  constexpr double small_part = 0.4;
  Span span;
  for (const BarValue& value : panel.values) {
    if (!value.mean || !std::isfinite(*value.mean)) continue;
    span.extend(value.ci95 ? value.ci95->low : *value.mean);
    span.extend(value.ci95 ? value.ci95->high : *value.mean);
  }
  if (span.empty()) return false;
  if (panel.ideal) span.extend(*panel.ideal);
  return span.low > 0 && span.high - span.low < small_part * span.high && span.high > span.low;
}

/// Zero, unless all values are far from it, the line of the ideal value and all whiskers, with room
/// for the values above them.
Axis axis_for(const BarPanel& panel, bool narrow) {
  const bool cut = far_from_zero(panel);
  Span span = cut ? Span{} : Span{0, 0};
  const auto extend = [&](double value) {
    if (std::isfinite(value)) span.extend(value);
  };
  if (panel.ideal) extend(*panel.ideal);
  for (const BarValue& value : panel.values) {
    if (value.mean) extend(*value.mean);
    if (value.mean && value.ci95) extend(value.ci95->low);
    if (value.mean && value.ci95) extend(value.ci95->high);
  }
  if (span.high - span.low <= 0) return Axis::even({0, 1});
  const double room = (narrow ? 0.28 : 0.13) * (span.high - span.low);
  if (span.high > 0) span.high += room;
  if (span.low < 0 || cut) span.low -= room;
  return Axis::even(span);
}

class BarsDrawing {
 public:
  explicit BarsDrawing(const Bars& bars)
      : bars_(bars),
        names_(captions(bars), panel_width(bars) / static_cast<double>(bars.labels.size())),
        layout_{static_cast<int>(bars.labels.size()), static_cast<int>(bars.panels.size()),
                panel_width(bars), names_.height()},
        canvas_(layout_.picture_width(), layout_.picture_height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.title(bars_.title);
    const bool cut = std::ranges::any_of(bars_.panels, far_from_zero);
    canvas_.text(std::string("bars: mean; whiskers: its 95 % interval over the frames") +
                     (cut ? "; dots: means on an axis that does not begin at zero" : ""),
                 BarLayout::left, canvas_.height() - 10, {.size = 9, .align = TextAlign::left});
    for (int p = 0; p < layout_.panels; ++p) {
      if (p % layout_.columns() == 0) {
        canvas_.letter(p / layout_.columns(), layout_.box(p).top - 12);
      }
      plot(bars_.panels[static_cast<std::size_t>(p)], layout_.box(p));
    }
    canvas_.draw(stem);
  }

 private:
  double middle_of(std::size_t variant) const { return static_cast<double>(variant) + 0.5; }

  void plot(const BarPanel& panel, const Box& box) {
    const Axis axis = axis_for(panel, layout_.narrow());
    Panel axes(canvas_, box, {0, double(layout_.variants)}, axis);
    const std::string ideal = panel.ideal_name.empty() ? "" : ", " + panel.ideal_name;
    const bool dashed = panel.ideal && *panel.ideal != 0;
    axes.title(panel.title + ideal + (dashed ? " (dashed)" : ""));
    std::vector<Bar> bars;
    std::vector<Whisker> whiskers;
    for (std::size_t v = 0; v < panel.values.size(); ++v) {
      const BarValue& value = panel.values[v];
      canvas_.tooltip(Box::sized(box.left + static_cast<double>(v) * layout_.slot(), box.top,
                                 layout_.slot(), box.height()),
                      bars_.labels[v] + "\n" + value_text(panel, v));
      write_value(axes, panel, v);
      if (!value.mean || !std::isfinite(*value.mean)) continue;
      const std::size_t count = panel.values.size();
      const double place = count > 1 ? 0.95 * double(v) / double(count - 1) : 0.4;
      bars.push_back({middle_of(v), *value.mean, viridis(place)});
      if (value.ci95) whiskers.push_back({middle_of(v), value.ci95->low, value.ci95->high});
    }
    const bool cut = far_from_zero(panel);
    if (!cut) axes.bars(bars, 0.66);
    if (axis.low < 0) axes.level(0, {ink::black, 0.5});
    if (dashed) axes.level(*panel.ideal, {ink::dark, 1, 2});
    axes.whiskers(whiskers, {ink::white, 3});  // seen on dark bars and on the paper
    axes.whiskers(whiskers, {ink::black, 1.2});
    for (const Bar& bar : bars) {
      if (cut) axes.marks({{bar.x, bar.height}}, {filled(0), bar.colour, 1.1});
    }
    axes.draw();
    names_.draw(canvas_, box.left, box.bottom);
  }

  /// The value at the end of its bar, or what stands in its place.
  void write_value(const Panel& axes, const BarPanel& panel, std::size_t v) {
    const double x = axes.x(middle_of(v));
    const BarValue& value = panel.values[v];
    if (!value.mean || !std::isfinite(*value.mean)) {
      const std::string& status = bars_.statuses[v];
      const double ground = far_from_zero(panel) ? axes.box().bottom : axes.y(0);
      canvas_.text(status.empty() ? "undefined" : status, x, ground - 6,
                   {.size = 9, .align = TextAlign::left, .upright = true, .colour = ink::alarm});
      return;
    }
    const bool down = *value.mean < 0;
    double end = *value.mean;
    if (value.ci95) end = down ? std::min(end, value.ci95->low) : std::max(end, value.ci95->high);
    const double gap = layout_.narrow() ? 4 : 8;
    TextStyle style{.size = 9, .upright = layout_.narrow(), .boxed = !layout_.narrow()};
    if (layout_.narrow()) style.align = down ? TextAlign::right : TextAlign::left;
    canvas_.text(fixed(*value.mean, panel.decimals), x, axes.y(end) + (down ? gap : -gap), style);
  }

  /// "AR: 1.116, 95 % interval 1.090 to 1.142".
  std::string value_text(const BarPanel& panel, std::size_t v) const {
    const BarValue& value = panel.values[v];
    const std::string& status = bars_.statuses[v];
    std::string text = panel.title + ": ";
    if (value.mean && std::isfinite(*value.mean)) {
      text += fixed(*value.mean, panel.decimals);
      if (value.ci95) {
        text += ", 95 % interval " + fixed(value.ci95->low, panel.decimals) + " to " +
                fixed(value.ci95->high, panel.decimals);
      }
      if (!status.empty()) text += " (" + status + ")";
    } else {
      text += status.empty() ? "undefined" : status;
    }
    return text;
  }

  const Bars& bars_;
  CategoryNames names_;
  BarLayout layout_;
  Canvas canvas_;
};

}  // namespace

void draw_bars(const Bars& bars, const std::filesystem::path& stem) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("bar chart: " + what);
  };
  if (bars.labels.empty() || bars.panels.empty()) refuse("nothing to draw");
  if (bars.statuses.size() != bars.labels.size()) refuse("a status for each label");
  for (const BarPanel& panel : bars.panels) {
    if (panel.values.size() != bars.labels.size()) {
      refuse(panel.title + ": a value for each label");
    }
  }
  BarsDrawing(bars).draw(stem);
}

BarChart::BarChart(const ChartRequest& request)
    : BarChart(request.place, read_row_labels(request.object, request.experiment),
               read_metrics(request.object, {kPublishedMetrics.begin(), kPublishedMetrics.end()})) {
}

BarChart::BarChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics)
    : Chart(std::move(place)), labels_(std::move(labels)), metrics_(std::move(metrics)) {}

Bars BarChart::bars_of(std::span<const ResultRow> rows, const std::string& title) const {
  Bars bars;
  bars.title = title;
  bars.labels = labels_;
  const ResultRow* truth = find_row(rows, "truth");
  for (const std::string& label : labels_) {
    bars.statuses.push_back(chart_status(find_row(rows, label)));
  }
  for (const Metric metric : metrics_) {
    BarPanel panel;
    panel.title = axis_title(metric);
    panel.decimals = decimals_of(metric);
    panel.ideal = ideal_of(metric, truth ? truth->metrics[metric].mean : std::nullopt);
    if (panel.ideal) panel.ideal_name = ideal_text(metric, *panel.ideal);
    for (const std::string& label : labels_) {
      const ResultRow* row = find_row(rows, label);
      panel.values.push_back(row ? BarValue{row->metrics[metric].mean, row->metrics[metric].ci95}
                                 : BarValue{});
    }
    bars.panels.push_back(std::move(panel));
  }
  return bars;
}

void BarChart::draw(std::span<const ResultRow> rows, const std::string& title,
                    const std::filesystem::path& folder) const {
  draw_bars(bars_of(rows, title), folder / name());
}

std::string BarChart::caption() const {
  return "means with their 95 % intervals, test set " + dataset();
}

}  // namespace ertbench
