#include "bench/charts/bars.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "bench/plot/canvas.h"
#include "bench/plot/gnuplot.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double kCharacter = 5.2;  ///< width of one at size 9, px

/// Places and sizes in px.
struct Layout {
  int variants;
  int panels;
  int panel_width;
  int label_height;  ///< below each panel
  bool upright;      ///< labels and values too wide for their bars stand on end

  static constexpr int kLeft = 64;
  static constexpr int kTop = 34;
  static constexpr int kTitle = 26;
  static constexpr int kPanelHeight = 170;
  static constexpr int kRight = 14;
  static constexpr int kNote = 20;

  int columns() const { return std::min(panels, 2); }
  int rows() const { return (panels + 1) / 2; }
  double slot() const { return double(panel_width) / variants; }
  int row_height() const { return kTitle + kPanelHeight + label_height; }
  int width() const { return columns() * (kLeft + panel_width) + kRight; }
  int height() const { return kTop + rows() * row_height() + kNote; }
  double left_of(int panel) const {
    return kLeft + (panel % columns()) * double(kLeft + panel_width);
  }
  double top_of(int panel) const {
    return kTop + double(panel / columns()) * row_height() + kTitle;
  }
  double middle_of(int panel, std::size_t variant) const {
    return left_of(panel) + (static_cast<double>(variant) + 0.5) * slot();
  }
  std::size_t characters() const { return static_cast<std::size_t>(slot() / kCharacter); }
};

/// What stands below a bar.
std::string caption(const Bars& chart, std::size_t variant) {
  const std::string& status = chart.statuses[variant];
  return chart.labels[variant] + (status.empty() ? "" : " (" + status + ")");
}

std::size_t longest_word(const std::string& text) {
  std::size_t longest = 0;
  std::istringstream in(text);
  for (std::string word; in >> word;) longest = std::max(longest, character_count(word));
  return longest;
}

Layout layout_for(const Bars& chart) {
  constexpr double least_slot = 46;
  constexpr int widest = 640;
  std::size_t word = 0;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < chart.labels.size(); ++i) {
    word = std::max(word, longest_word(caption(chart, i)));
    longest = std::max(longest, character_count(caption(chart, i)));
  }
  const int variants = static_cast<int>(chart.labels.size());
  const double slot = std::max(least_slot, kCharacter * (static_cast<double>(word) + 1));
  Layout layout{variants, static_cast<int>(chart.panels.size()), 0, 0, slot * variants > widest};
  if (layout.upright) {
    layout.panel_width = std::clamp(variants * 22, 380, 1200);
    layout.label_height = static_cast<int>(kCharacter * static_cast<double>(longest)) + 14;
  } else {
    layout.panel_width = std::max(300, static_cast<int>(slot * variants));
    std::size_t lines = 1;
    for (std::size_t i = 0; i < chart.labels.size(); ++i) {
      lines = std::max(lines, wrapped(caption(chart, i), layout.characters()).size());
    }
    layout.label_height = static_cast<int>(lines) * 11 + 16;
  }
  return layout;
}

struct Axis {
  double low = 0;
  double high = 0;
};

/// Zero, the line of the ideal value and all whiskers, with room for the values above them.
Axis axis_for(const BarPanel& panel, bool upright) {
  Axis axis;
  const auto extend = [&](double value) {
    if (!std::isfinite(value)) return;
    axis.low = std::min(axis.low, value);
    axis.high = std::max(axis.high, value);
  };
  if (panel.ideal) extend(*panel.ideal);
  for (const BarValue& value : panel.values) {
    if (value.mean) extend(*value.mean);
    if (value.mean && value.ci95) extend(value.ci95->low);
    if (value.mean && value.ci95) extend(value.ci95->high);
  }
  if (axis.high - axis.low <= 0) return {0, 1};
  const double room = (upright ? 0.28 : 0.13) * (axis.high - axis.low);
  if (axis.high > 0) axis.high += room;
  if (axis.low < 0) axis.low -= room;
  return axis;
}

Colour colour_of(std::size_t variant, std::size_t count) {
  return viridis(count > 1 ? 0.95 * double(variant) / double(count - 1) : 0.4);
}

class Drawing {
 public:
  explicit Drawing(const Bars& chart)
      : chart_(chart), layout_(layout_for(chart)), canvas_(layout_.width(), layout_.height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.out() << "set multiplot\nunset key\nset border 3 linecolor '#404040'\n"
                  << "set tics nomirror font ',9'\nunset xtics\nset boxwidth 0.66\n"
                  << "set style textbox opaque noborder fillcolor 'white' margins 0.3,0.3\n"
                  << "set xrange [0:" << layout_.variants << "]\n";
    canvas_.label(one_line(chart_.title, static_cast<std::size_t>(layout_.width() / 7)),
                  layout_.width() / 2.0, 16, 12, "center");
    canvas_.label("bars: mean; whiskers: its 95 % interval over the frames", Layout::kLeft,
                  layout_.height() - 10, 9, "left");
    for (int p = 0; p < layout_.panels; ++p) plot(p);
    canvas_.out() << "unset multiplot\n";
    canvas_.draw(files_, stem);
  }

 private:
  void plot(int p) {
    const BarPanel& panel = chart_.panels[static_cast<std::size_t>(p)];
    const double top = layout_.top_of(p);
    const Axis axis = axis_for(panel, layout_.upright);
    if (p % layout_.columns() == 0) {
      const char letter = static_cast<char>('a' + p / layout_.columns());
      canvas_.label(std::string("(") + letter + ")", 14, top - 12, 12, "left");
    }
    const std::string ideal = panel.ideal_name.empty() ? "" : ", " + panel.ideal_name;
    const std::string dashed = panel.ideal && *panel.ideal != 0 ? " (dashed)" : "";
    canvas_.label(panel.title + ideal + dashed, layout_.left_of(p) + layout_.panel_width / 2.0,
                  top - 12, 11, "center");
    canvas_.area(layout_.left_of(p), top, layout_.panel_width, Layout::kPanelHeight);
    std::ostream& out = canvas_.out();
    out << "set yrange [" << axis.low << ":" << axis.high << "]\n";
    if (axis.low < 0) out << "set xzeroaxis linetype -1 linewidth 0.5\n";
    for (std::size_t v = 0; v < chart_.labels.size(); ++v) {
      words(p, panel, v, axis);
      canvas_.tooltip(layout_.middle_of(p, v) - layout_.slot() / 2, top, layout_.slot(),
                      Layout::kPanelHeight, chart_.labels[v] + "\n" + value_text(panel, v));
    }
    plot_bars(panel);
    out << "unset label\nunset arrow\nunset xzeroaxis\n";
  }

  /// The label below and the value, or what stands in its place.
  void words(int p, const BarPanel& panel, std::size_t v, const Axis& axis) {
    const double x = layout_.middle_of(p, v);
    const double bottom = layout_.top_of(p) + Layout::kPanelHeight;
    if (layout_.upright) {
      canvas_.label(caption(chart_, v), x, bottom + 6, 9, "right rotate by 90");
    } else {
      canvas_.lines(caption(chart_, v), layout_.characters(), x, bottom + 10, 9);
    }
    const auto y_of = [&](double value) {
      return bottom - Layout::kPanelHeight * (value - axis.low) / (axis.high - axis.low);
    };
    const BarValue& value = panel.values[v];
    const std::string turned = layout_.upright ? "left rotate by 90" : "center";
    if (!value.mean || !std::isfinite(*value.mean)) {
      const std::string& status = chart_.statuses[v];
      const std::string text = status.empty() ? "undefined" : status;
      canvas_.label(text, x, y_of(0) - 6, 9, "left rotate by 90 textcolor '#a00000'");
      return;
    }
    const bool down = *value.mean < 0;
    double end = *value.mean;
    if (value.ci95) end = down ? std::min(end, value.ci95->low) : std::max(end, value.ci95->high);
    const double gap = layout_.upright ? 4 : 8;
    canvas_.label(fixed(*value.mean, panel.decimals), x, y_of(end) + (down ? gap : -gap), 9,
                  (down && layout_.upright ? "right rotate by 90" : turned) +
                      (layout_.upright ? " front" : " front boxed"));
  }

  /// "AR: 1.116, 95 % interval 1.090 to 1.142".
  std::string value_text(const BarPanel& panel, std::size_t v) const {
    const BarValue& value = panel.values[v];
    const std::string& status = chart_.statuses[v];
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

  void plot_bars(const BarPanel& panel) {
    std::ostringstream bars;
    std::ostringstream whiskers;
    bars.precision(10);
    whiskers.precision(10);
    const std::size_t count = panel.values.size();
    for (std::size_t v = 0; v < count; ++v) {
      const BarValue& value = panel.values[v];
      if (!value.mean || !std::isfinite(*value.mean)) continue;
      const double x = static_cast<double>(v) + 0.5;
      bars << x << ' ' << *value.mean << ' ' << colour_of(v, count).number() << '\n';
      if (!value.ci95) continue;
      whiskers << x << ' ' << value.ci95->low << ' ' << value.ci95->high << '\n';
    }
    std::string plots;
    if (const std::string text = bars.str(); !text.empty()) {
      plots = file(text) + " using 1:2:3 with boxes fillstyle solid border linecolor 'black' " +
              "linewidth 0.6 linecolor rgb variable, ";
    }
    if (panel.ideal && *panel.ideal != 0) {
      const std::string ends = "0 " + std::to_string(*panel.ideal) + "\n" +
                               std::to_string(layout_.variants) + " " +
                               std::to_string(*panel.ideal) + "\n";
      plots += file(ends) + " using 1:2 with lines dashtype 2 linewidth 1 linecolor '#404040', ";
    }
    if (const std::string text = whiskers.str(); !text.empty()) {
      // White under black: seen on dark bars and on the paper.
      const std::string name = file(text);
      for (const char* style :
           {"linewidth 3 linecolor 'white'", "linewidth 1.2 linecolor 'black'"}) {
        plots +=
            name + " using 1:2:(0):($3-$2) with vectors heads size 0.07,90 fixed " + style + ", ";
      }
    }
    canvas_.out() << "plot " << plots << "NaN notitle\n";
  }

  std::string file(const std::string& text) {
    const std::string name = "bars" + std::to_string(files_.size()) + ".txt";
    files_[name] = text;
    return "'" + name + "'";
  }

  const Bars& chart_;
  Layout layout_;
  Canvas canvas_;
  FileContents files_;
};

}  // namespace

void draw_bars(const Bars& chart, const std::filesystem::path& stem) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("bar chart: " + what);
  };
  if (chart.labels.empty() || chart.panels.empty()) refuse("nothing to draw");
  if (chart.statuses.size() != chart.labels.size()) refuse("a status for each label");
  for (const BarPanel& panel : chart.panels) {
    if (panel.values.size() != chart.labels.size())
      refuse(panel.title + ": a value for each label");
  }
  Drawing(chart).draw(stem);
}

}  // namespace ertbench
