#include "bench/report/heat_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/plot/image_panel.h"
#include "bench/plot/panel.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double line_height = 12.5;      ///< of the rows' names, px
constexpr std::size_t longest_line = 56;  ///< of the rows' names, characters
constexpr LineStyle best_line{rgb(0xd40000), 1.8};
constexpr LineStyle published_line{ink::black, 1.4, 3};

/// Places and sizes in px.
struct MapLayout {
  int columns;  ///< cells in a row
  int rows;
  int panels;
  double cell_width;
  double cell_height;
  double notes_width;
  double left;          ///< of the first panel: the names of the rows stand there
  double names_height;  ///< of the columns, below each panel
  double x_name;        ///< below the names of the columns
  double y_name;        ///< left of the names of the rows

  static constexpr double top = 34;
  static constexpr double title = 26;
  static constexpr double bar = 84;    ///< colour bar with its ticks
  static constexpr double notes = 52;  ///< what the marks mean

  int across() const { return std::min(panels, 2); }
  double panel_width() const { return columns * cell_width; }
  double panel_height() const { return rows * cell_height; }
  double below() const { return names_height + x_name; }
  double width() const { return std::max(notes_width, across() * (left + panel_width() + bar)); }
  double height() const {
    return top + (panels + 1) / 2 * (title + panel_height() + below()) + notes;
  }
  Box box(int panel) const {
    return Box::sized(left + panel % across() * (left + panel_width() + bar),
                      top + title + panel / across() * (title + panel_height() + below()),
                      panel_width(), panel_height());
  }
};

/// What the widest of the texts in the cells needs.
double widest_text(const HeatMap& map, int size) {
  double widest = 0;
  for (const HeatMapPanel& panel : map.panels) {
    for (const std::string& text : panel.texts) widest = std::max(widest, text_width(text, size));
  }
  return widest;
}

MapLayout map_layout_for(const HeatMap& map) {
  MapLayout layout{};
  layout.columns = static_cast<int>(map.x_values.size());
  layout.rows = static_cast<int>(map.y_values.size());
  layout.panels = static_cast<int>(map.panels.size());
  const bool texts = std::ranges::any_of(
      map.panels, [](const HeatMapPanel& panel) { return !panel.texts.empty(); });
  layout.cell_width =
      texts ? widest_text(map, 10) + 6 : std::clamp(420.0 / layout.columns, 12.0, 62.0);
  double longest = 0;
  std::size_t lines = 1;
  for (const std::string& value : map.y_values) {
    const std::vector<std::string> words = wrapped(value, longest_line);
    lines = std::max(lines, words.size());
    for (const std::string& line : words) {
      longest = std::max(longest, text_width(line, 10));
    }
  }
  layout.cell_height =
      std::clamp(320.0 / layout.rows,
                 std::max(texts ? 19.0 : 12.0, line_height * static_cast<double>(lines)), 40.0);
  layout.x_name = map.x_name.empty() ? 8 : 34;
  layout.y_name = map.y_name.empty() ? 0 : 24;
  layout.left = 14 + layout.y_name + longest;
  layout.names_height = CategoryNames(map.x_values, layout.cell_width).height();
  layout.notes_width = layout.left + 40 +
                       std::max(text_width(map.best_note, 10), text_width(map.published_note, 10));
  return layout;
}

/// The ends of the colours, with ticks. `clipped`: values above `high` exist.
Axis colours_between(double low, double high, bool clipped, int decimals) {
  constexpr int steps = 4;
  Axis axis{low, high};
  for (int i = 0; i <= steps; ++i) {
    const double value = low + (high - low) * i / steps;
    const std::string above = i == steps && clipped ? "≥ " : "";
    axis.ticks.push_back({value, above + fixed(value, decimals)});
  }
  return axis;
}

/// From the best value to the worst, or to four times as far as the median, whichever is nearer.
Axis colours_for(const HeatMap& map, const HeatMapPanel& panel) {
  if (panel.range) {
    return colours_between(panel.range->first, panel.range->second, false, panel.decimals);
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < panel.colours.size(); ++i) {
    const auto& value = panel.colours[i];
    if (map.statuses[i].empty() && value && std::isfinite(*value)) values.push_back(*value);
  }
  if (values.empty()) return colours_between(0, 1, false, panel.decimals);
  const SortedValues sorted = values;
  const double middle = median(sorted);
  const double low = sorted.smallest();
  double high = sorted.largest();
  const double limit = low + 4 * (middle - low);
  const bool clipped = values.size() >= 8 && middle > low && limit < 0.9 * high;
  if (clipped) high = limit;
  const double digit = std::pow(10, -panel.decimals);  // what is less cannot be read in the cells
  if (high - low < digit) high = low + 4 * digit;
  return colours_between(low, high, clipped, panel.decimals);
}

class HeatMapDrawing {
 public:
  explicit HeatMapDrawing(const HeatMap& map)
      : map_(map), layout_(map_layout_for(map)), canvas_(layout_.width(), layout_.height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.title(map_.title);
    for (int p = 0; p < layout_.panels; ++p) {
      panel(map_.panels[static_cast<std::size_t>(p)], layout_.box(p));
    }
    notes();
    canvas_.draw(stem);
  }

 private:
  Box cell_of(const Box& box, int x, int y) const {
    return Box::sized(box.left + x * layout_.cell_width,
                      box.top + (layout_.rows - 1 - y) * layout_.cell_height, layout_.cell_width,
                      layout_.cell_height);
  }

  void panel(const HeatMapPanel& panel, const Box& box) {
    const Axis colours = colours_for(map_, panel);
    const std::string coloured =
        panel.quantity == panel.title ? "" : ", coloured by " + panel.quantity;
    canvas_.text(panel.title + coloured, box.middle(), box.top - 12, {.size = 11});
    any_ = std::ranges::any_of(panel.values, [](const auto& value) { return value.has_value(); });
    for (int y = 0; y < layout_.rows; ++y) {
      for (int x = 0; x < layout_.columns; ++x) cell(panel, colours, cell_of(box, x, y), x, y);
    }
    axes(box);
    if (any_) {
      draw_colour_bar(canvas_, {box.right + 10, box.top, box.right + 21, box.bottom}, colours);
    } else {
      canvas_.rectangle(
          {box.middle() - 60, box.centre() - 11, box.middle() + 60, box.centre() + 11},
          {.fill = ink::white, .border = LineStyle{}, .front = true});
      canvas_.text("no results yet", box.middle(), box.centre(), {.size = 11});
    }
    if (map_.published) mark(cell_of(box, map_.published->x, map_.published->y), true);
    if (map_.best) mark(cell_of(box, map_.best->x, map_.best->y), false);
  }

  void cell(const HeatMapPanel& panel, const Axis& colours, const Box& box, int x, int y) {
    const auto index = static_cast<std::size_t>(y * layout_.columns + x);
    canvas_.tooltip(box, value_text(panel, x, y));
    const std::string& status = map_.statuses[index];
    const auto& value = panel.values[index];
    const auto& colour_value = panel.colours[index];
    if (!status.empty() || !value || !colour_value || !std::isfinite(*colour_value)) {
      crossed_out(box, status.empty() ? "undefined" : status);
      return;
    }
    const Colour colour = viridis(colours.share(*colour_value));
    canvas_.rectangle(box, {.fill = colour, .border = LineStyle{ink::white}});
    const std::string text =
        panel.texts.empty() ? fixed(*value, panel.decimals) : panel.texts[index];
    write(text, box, box.width() >= 46 ? 10 : 8,
          colour.lightness() > 0.55 ? ink::black : ink::white);
  }

  void crossed_out(const Box& box, const std::string& word) {
    canvas_.rectangle(box, {.fill = rgb(0xd0d0d0), .border = LineStyle{ink::white}});
    const LineStyle line{rgb(0x8a8a8a), 0.8};
    canvas_.line(box.left + 2, box.top + 2, box.right - 2, box.bottom - 2, line);
    canvas_.line(box.left + 2, box.bottom - 2, box.right - 2, box.top + 2, line);
    if (any_) write(word, box, 8, ink::black);
  }

  /// In the middle of the cell, where it has room.
  void write(const std::string& text, const Box& cell, int size, const Colour& colour) {
    if (text_width(text, size) > cell.width() - 2 || cell.height() < 14) return;
    canvas_.text(text, cell.middle(), cell.centre(), {.size = size, .colour = colour});
  }

  /// "alpha = 0.001, beta = 0.1" and below it "AR: 1.02; |AR − 1|: 0.020".
  std::string value_text(const HeatMapPanel& panel, int x, int y) const {
    const auto index = static_cast<std::size_t>(y * layout_.columns + x);
    const auto number = [&](const std::optional<double>& value) {
      return value && std::isfinite(*value) ? fixed(*value, panel.decimals) : "undefined";
    };
    const auto named = [](const std::string& name, const std::string& value) {
      return name.empty() ? value : name + " = " + value;
    };
    std::string text = named(map_.x_name, map_.x_values[static_cast<std::size_t>(x)]) + ", " +
                       named(map_.y_name, map_.y_values[static_cast<std::size_t>(y)]) + "\n";
    if (const std::string& status = map_.statuses[index]; !status.empty()) return text + status;
    if (!panel.texts.empty()) return text + panel.texts[index];
    text += panel.title + ": " + number(panel.values[index]);
    if (panel.quantity != panel.title) {
      text += "; " + panel.quantity + ": " + number(panel.colours[index]);
    }
    return text;
  }

  void axes(const Box& box) {
    CategoryNames(map_.x_values, layout_.cell_width).draw(canvas_, box.left, box.bottom);
    const TextStyle style{.size = layout_.cell_height >= 14 ? 10 : 8, .align = TextAlign::right};
    for (int y = 0; y < layout_.rows; ++y) {
      const auto lines = wrapped(map_.y_values[static_cast<std::size_t>(y)], longest_line);
      const double first =
          cell_of(box, 0, y).centre() - line_height * (static_cast<double>(lines.size()) - 1) / 2;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        canvas_.text(lines[i], box.left - 5, first + line_height * static_cast<double>(i), style);
      }
    }
    canvas_.text(map_.x_name, box.middle(), box.bottom + layout_.names_height + 12, {.size = 11});
    canvas_.text(map_.y_name, box.left - layout_.left + 16, box.centre(),
                 {.size = 11, .upright = true});
  }

  /// An outline: the paper's dotted, ours whole; light beside dark, so that any cell shows it.
  void mark(const Box& cell, bool published) {
    const double inset = published ? 4.5 : 1.5;
    const Box box{cell.left + inset, cell.top + inset, cell.right - inset, cell.bottom - inset};
    canvas_.rectangle(box, {.border = LineStyle{ink::white, 3.4}, .front = true});
    canvas_.rectangle(box, {.border = published ? published_line : best_line, .front = true});
  }

  void notes() {
    const double y = canvas_.height() - MapLayout::notes + 14;
    const TextStyle style{.align = TextAlign::left};
    const auto note = [&](double at, const LineStyle& line, const std::string& text) {
      canvas_.rectangle(Box::sized(layout_.left, at - 6, 18, 12), {.border = line});
      canvas_.text(text, layout_.left + 25, at, style);
    };
    if (map_.best) note(y, best_line, map_.best_note);
    if (map_.published) {
      note(y + 18, published_line, map_.published_note);
    } else if (!map_.published_note.empty()) {
      canvas_.text(map_.published_note, layout_.left, y + 18, style);
    }
  }

  const HeatMap& map_;
  MapLayout layout_;
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
  HeatMapDrawing(map).draw(stem);
}

}  // namespace ertbench
