#include "bench/charts/heat_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"
#include "core/quantile.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Places and sizes in px.
struct Layout {
  int columns;  ///< cells in a row
  int rows;
  int panels;
  double cell_width;
  double cell_height;
  double notes_width;
  double left;  ///< of the first panel: the names of the rows stand there

  static constexpr int kTop = 34;
  static constexpr int kTitle = 26;
  static constexpr int kBelow = 50;  ///< names of the columns
  static constexpr int kBar = 74;    ///< colour bar with its ticks
  static constexpr int kNotes = 52;  ///< what the marks mean

  int across() const { return std::min(panels, 2); }
  double panel_width() const { return columns * cell_width; }
  double panel_height() const { return rows * cell_height; }
  int width() const {
    return static_cast<int>(std::max(notes_width, across() * (left + panel_width() + kBar)));
  }
  int height() const {
    const int down = (panels + 1) / 2;
    return static_cast<int>(kTop + down * (kTitle + panel_height() + kBelow) + kNotes);
  }
  double left_of(int panel) const {
    return left + (panel % across()) * (left + panel_width() + kBar);
  }
  double top_of(int panel) const {
    return kTop + kTitle + (panel / across()) * (kTitle + panel_height() + kBelow);
  }
};

Layout layout_for(const HeatMap& map) {
  Layout layout{};
  layout.columns = static_cast<int>(map.x_values.size());
  layout.rows = static_cast<int>(map.y_values.size());
  layout.panels = static_cast<int>(map.panels.size());
  const bool texts = std::any_of(map.panels.begin(), map.panels.end(),
                                 [](const HeatMapPanel& panel) { return !panel.texts.empty(); });
  layout.cell_width = std::clamp(420.0 / layout.columns, texts ? 66.0 : 12.0, texts ? 66.0 : 62.0);
  layout.cell_height = std::clamp(320.0 / layout.rows, texts ? 19.0 : 12.0, 40.0);
  std::size_t longest = 0;
  for (const std::string& value : map.y_values) longest = std::max(longest, character_count(value));
  layout.left = 38 + 6.0 * static_cast<double>(longest);
  const std::size_t note =
      std::max(character_count(map.best_note), character_count(map.published_note));
  layout.notes_width = layout.left + 40 + 6.0 * static_cast<double>(note);
  return layout;
}

/// Where the colours end.
struct Scale {
  double low = 0;
  double high = 1;
  bool clipped = false;  ///< values above `high` exist

  double place(double value) const { return std::clamp((value - low) / (high - low), 0.0, 1.0); }
};

/// From the best value to the worst, or to four times as far as the median, whichever is nearer.
Scale scale_for(const HeatMap& map, const HeatMapPanel& panel) {
  if (panel.range) return {panel.range->first, panel.range->second, false};
  std::vector<double> values;
  for (std::size_t i = 0; i < panel.colours.size(); ++i) {
    const auto& value = panel.colours[i];
    if (map.statuses[i].empty() && value && std::isfinite(*value)) values.push_back(*value);
  }
  Scale scale;
  if (values.empty()) return scale;
  const SortedValues sorted = values;
  const double middle = median(sorted);
  scale.low = sorted.smallest();
  scale.high = sorted.largest();
  const double limit = scale.low + 4 * (middle - scale.low);
  if (values.size() >= 8 && middle > scale.low && limit < 0.9 * scale.high) {
    scale.high = limit;
    scale.clipped = true;
  }
  const double digit = std::pow(10, -panel.decimals);  // what is less cannot be read in the cells
  if (scale.high - scale.low < digit) scale.high = scale.low + 4 * digit;
  return scale;
}

class Drawing {
 public:
  explicit Drawing(const HeatMap& map)
      : map_(map), layout_(layout_for(map)), canvas_(layout_.width(), layout_.height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.out() << "set multiplot\n";
    canvas_.label(one_line(map_.title, static_cast<std::size_t>(layout_.width() / 7)),
                  layout_.width() / 2.0, 16, 12, "center");
    for (int p = 0; p < layout_.panels; ++p) panel(p);
    notes();
    canvas_.finish_marks();
    canvas_.out() << "unset multiplot\n";
    canvas_.draw({}, stem);
  }

 private:
  double x_of(int p, int x) const { return layout_.left_of(p) + x * layout_.cell_width; }
  double y_of(int p, int y) const {
    return layout_.top_of(p) + (layout_.rows - 1 - y) * layout_.cell_height;
  }

  void panel(int p) {
    const HeatMapPanel& panel = map_.panels[static_cast<std::size_t>(p)];
    const Scale scale = scale_for(map_, panel);
    const double middle = layout_.left_of(p) + layout_.panel_width() / 2;
    const std::string coloured =
        panel.quantity == panel.title ? "" : ", coloured by " + panel.quantity;
    canvas_.label(panel.title + coloured, middle, layout_.top_of(p) - 12, 11, "center");
    any_ = std::any_of(panel.values.begin(), panel.values.end(),
                       [](const auto& value) { return value.has_value(); });
    for (int y = 0; y < layout_.rows; ++y) {
      for (int x = 0; x < layout_.columns; ++x) cell(p, panel, scale, x, y);
    }
    axes(p);
    if (any_) {
      colour_bar(p, panel, scale);
    } else {
      canvas_.rectangle(middle - 60, layout_.top_of(p) + layout_.panel_height() / 2 - 11, 120, 22,
                        "front fillstyle solid border linecolor '#404040' fillcolor 'white'");
      canvas_.label("no results yet", middle, layout_.top_of(p) + layout_.panel_height() / 2, 11,
                    "center front");
    }
    if (map_.published) mark(x_of(p, map_.published->x), y_of(p, map_.published->y), true);
    if (map_.best) mark(x_of(p, map_.best->x), y_of(p, map_.best->y), false);
  }

  void cell(int p, const HeatMapPanel& panel, const Scale& scale, int x, int y) {
    const auto index = static_cast<std::size_t>(y * layout_.columns + x);
    const double left = x_of(p, x);
    const double top = y_of(p, y);
    const double width = layout_.cell_width;
    const double height = layout_.cell_height;
    const auto fill = [&](const std::string& colour) {
      canvas_.rectangle(left, top, width, height,
                        "fillstyle solid border linecolor 'white' fillcolor '" + colour + "'");
    };
    canvas_.tooltip(left, top, width, height, value_text(panel, x, y));
    const std::string& status = map_.statuses[index];
    const auto& value = panel.values[index];
    const auto& colour_value = panel.colours[index];
    if (!status.empty() || !value || !colour_value || !std::isfinite(*colour_value)) {
      fill("#d0d0d0");
      const std::string line = "linecolor '#8a8a8a' linewidth 0.8";
      canvas_.line(left + 2, top + 2, left + width - 2, top + height - 2, line);
      canvas_.line(left + 2, top + height - 2, left + width - 2, top + 2, line);
      const std::string word = status.empty() ? "undefined" : status;
      if (any_ && 4.6 * static_cast<double>(word.size()) < width + 2 && height >= 16) {
        canvas_.label(word, left + width / 2, top + height / 2, 8, "center front");
      }
      return;
    }
    const Colour colour = viridis(scale.place(*colour_value));
    fill(colour.hex());
    const std::string text =
        panel.texts.empty() ? fixed(*value, panel.decimals) : panel.texts[index];
    const double size = width >= 46 ? 10 : 8;
    if (0.58 * size * static_cast<double>(character_count(text)) > width - 3 || height < 14) return;
    canvas_.label(text, left + width / 2, top + height / 2, static_cast<int>(size),
                  std::string("center front textcolor '") +
                      (colour.lightness() > 0.55 ? "black" : "white") + "'");
  }

  /// "alpha = 0.001, beta = 0.1" and below it "AR: 1.02; |AR − 1|: 0.020".
  std::string value_text(const HeatMapPanel& panel, int x, int y) const {
    const auto index = static_cast<std::size_t>(y * layout_.columns + x);
    const auto number = [&](const std::optional<double>& value) {
      return value && std::isfinite(*value) ? fixed(*value, panel.decimals) : "undefined";
    };
    std::string text = map_.x_name + " = " + map_.x_values[static_cast<std::size_t>(x)] + ", " +
                       map_.y_name + " = " + map_.y_values[static_cast<std::size_t>(y)] + "\n";
    if (const std::string& status = map_.statuses[index]; !status.empty()) return text + status;
    if (!panel.texts.empty()) return text + panel.texts[index];
    text += panel.title + ": " + number(panel.values[index]);
    if (panel.quantity != panel.title) {
      text += "; " + panel.quantity + ": " + number(panel.colours[index]);
    }
    return text;
  }

  void axes(int p) {
    const double bottom = layout_.top_of(p) + layout_.panel_height();
    for (int x = 0; x < layout_.columns; ++x) {
      const std::string& text = map_.x_values[static_cast<std::size_t>(x)];
      const double middle = x_of(p, x) + layout_.cell_width / 2;
      const bool fits = 5.8 * static_cast<double>(character_count(text)) < layout_.cell_width;
      canvas_.label(text, middle, bottom + (fits ? 10 : 4), fits ? 10 : 8,
                    fits ? "center" : "right rotate by 90");
    }
    for (int y = 0; y < layout_.rows; ++y) {
      canvas_.label(map_.y_values[static_cast<std::size_t>(y)], layout_.left_of(p) - 5,
                    y_of(p, y) + layout_.cell_height / 2, layout_.cell_height >= 14 ? 10 : 8,
                    "right");
    }
    canvas_.label(map_.x_name, layout_.left_of(p) + layout_.panel_width() / 2, bottom + 32, 11,
                  "center");
    canvas_.label(map_.y_name, layout_.left_of(p) - layout_.left + 16,
                  layout_.top_of(p) + layout_.panel_height() / 2, 11, "center rotate by 90");
  }

  void colour_bar(int p, const HeatMapPanel& panel, const Scale& scale) {
    constexpr int steps = 64;
    constexpr int ticks = 4;
    const double left = layout_.left_of(p) + layout_.panel_width() + 10;
    const double top = layout_.top_of(p);
    const double height = layout_.panel_height();
    for (int i = 0; i < steps; ++i) {
      canvas_.rectangle(
          left, top + height * (steps - 1 - i) / steps, 11, height / steps + 0.4,
          "fillstyle solid noborder fillcolor '" + viridis((i + 0.5) / steps).hex() + "'");
    }
    for (int i = 0; i <= ticks; ++i) {
      const double y = top + height * (1 - double(i) / ticks);
      const double value = scale.low + (scale.high - scale.low) * i / ticks;
      const std::string above = i == ticks && scale.clipped ? "≥ " : "";
      canvas_.line(left + 11, y, left + 14, y, "linecolor '#404040'");
      canvas_.label(above + fixed(value, panel.decimals), left + 17, y, 9, "left");
    }
  }

  /// An outline: the paper's dashed, ours whole; light beside dark, so that any cell shows it.
  void mark(double left, double top, bool published) {
    const double inset = published ? 4.5 : 1.5;
    const auto outline = [&](const std::string& style) {
      canvas_.rectangle(left + inset, top + inset, layout_.cell_width - 2 * inset,
                        layout_.cell_height - 2 * inset, "front fillstyle empty border " + style);
    };
    outline("linecolor 'white' linewidth 3.4");
    outline(published ? "linecolor 'black' linewidth 1.4 dashtype (4,3)"
                      : "linecolor '#d40000' linewidth 1.8");
  }

  void notes() {
    const double y = layout_.height() - Layout::kNotes + 14;
    const auto note = [&](double at, const std::string& style, const std::string& text) {
      canvas_.rectangle(layout_.left, at - 6, 18, 12, "fillstyle empty border " + style);
      canvas_.label(text, layout_.left + 25, at, 10, "left");
    };
    if (map_.best) note(y, "linecolor '#d40000' linewidth 1.8", map_.best_note);
    if (map_.published) {
      note(y + 18, "linecolor 'black' linewidth 1.4 dashtype (4,3)", map_.published_note);
    } else if (!map_.published_note.empty()) {
      canvas_.label(map_.published_note, layout_.left, y + 18, 10, "left");
    }
  }

  const HeatMap& map_;
  Layout layout_;
  Canvas canvas_;
  bool any_ = false;  ///< whether the panel has a value at all
};

}  // namespace

void draw_heat_map(const HeatMap& map, const std::filesystem::path& stem) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("heat map: " + what);
  };
  const std::size_t cells = map.x_values.size() * map.y_values.size();
  if (cells == 0 || map.panels.empty()) refuse("nothing to draw");
  if (map.statuses.size() != cells) refuse("a status for each cell");
  for (const HeatMapPanel& panel : map.panels) {
    if (panel.values.size() != cells || panel.colours.size() != cells) {
      refuse(panel.title + ": a value and a colour for each cell");
    }
  }
  Drawing(map).draw(stem);
}

}  // namespace ertbench
