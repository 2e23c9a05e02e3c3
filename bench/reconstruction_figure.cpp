#include "bench/reconstruction_figure.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "bench/canvas.h"
#include "bench/colour_scale.h"
#include "bench/gnuplot.h"
#include "bench/palette.h"
#include "bench/text.h"

namespace ertbench {
namespace {

/// Places and sizes in px from the top left corner; panels are squares.
struct Layout {
  int scenes;
  int columns;
  int panel;
  std::vector<std::vector<std::string>> titles;

  static constexpr int kLeft = 27;
  static constexpr int kRight = 86;
  static constexpr int kGap = 9;
  static constexpr int kCaption = 22;  ///< below each panel, with the gap to the next
  static constexpr int kLine = 13;     ///< of a title
  static constexpr int kBorder = 7;

  int title_height() const {
    std::size_t lines = 1;
    for (const auto& title : titles) lines = std::max(lines, title.size());
    return static_cast<int>(lines) * kLine;
  }
  int width() const { return kLeft + columns * panel + (columns - 1) * kGap + kRight; }
  int height() const { return 2 * kBorder + title_height() + scenes * (panel + kCaption); }
  int bar_height() const { return std::min(scenes, 3) * (panel + kCaption) - kCaption; }
  int left_of(int column) const { return kLeft + column * (panel + kGap); }
  int top_of(int scene) const { return kBorder + title_height() + 4 + scene * (panel + kCaption); }
};

Layout layout_for(const ReconstructionFigure& figure) {
  constexpr int widest = 950;  // px of all panels and gaps
  constexpr int max_lines = 3;
  Layout layout{};
  layout.scenes = static_cast<int>(figure.conductivity.rows());
  layout.columns = static_cast<int>(figure.columns.size()) + 1;
  layout.panel = std::clamp(widest / layout.columns - Layout::kGap, 92, 145);
  const auto characters = static_cast<std::size_t>(layout.panel / 6.3);
  layout.titles = {{"truth"}};
  for (const FigureColumn& column : figure.columns) {
    std::vector<std::string> lines = wrapped(column.label, characters);
    if (lines.size() > max_lines) {
      lines.resize(max_lines);
      lines.back() = one_line(lines.back(), characters - 1);
      if (!lines.back().ends_with("…")) lines.back() += "…";
    }
    layout.titles.push_back(std::move(lines));
  }
  return layout;
}

void check(const ReconstructionFigure& figure) {
  const auto scenes = figure.conductivity.rows();
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("figure of reconstructions: " + what);
  };
  if (scenes < 1) refuse("no scene");
  if (figure.conductivity.cols() != figure.sensor.pixels()) refuse("images of another size");
  if (figure.row_labels.size() != static_cast<std::size_t>(scenes))
    refuse("a label for each scene");
  for (const FigureColumn& column : figure.columns) {
    const bool fits =
        column.changes.rows() == scenes && column.changes.cols() == figure.sensor.pixels();
    if (column.failure.empty() && !fits) refuse(column.label + ": images of another size");
    const bool has_errors = column.errors.size() == static_cast<std::size_t>(scenes);
    if (!column.errors.empty() && !has_errors) refuse(column.label + ": an error for each scene");
  }
}

/// Every pixel is written as a square of this many: some viewers of SVG smooth the pictures in it,
/// which then blurs the edges of the pixels only.
constexpr int kRepeat = 4;

/// A data file: a matrix, row 0 first.
std::string image_file(const Eigen::Ref<const Eigen::RowVectorXd>& image, int grid,
                       const ColourScale& scale) {
  std::ostringstream out;
  for (int row = 0; row < grid * kRepeat; ++row) {
    for (int column = 0; column < grid * kRepeat; ++column) {
      const double value = image[column / kRepeat + grid * (row / kRepeat)];
      if (std::isfinite(value)) {
        out << std::clamp(value, scale.low, scale.high) << ' ';
      } else {
        out << "NaN ";
      }
    }
    out << '\n';
  }
  return out.str();
}

/// The palette from end to end, for the colour bar: 256 rows.
std::string bar_file(const ColourScale& scale) {
  std::ostringstream out;
  for (int i = 0; i < 256; ++i) {
    const double value = scale.low + (scale.high - scale.low) * (i + 0.5) / 256;
    out << value << ' ' << value << '\n';
  }
  return out.str();
}

std::string electrodes(const Sensor& sensor) {
  std::ostringstream out;
  const Eigen::Matrix2Xd positions = electrode_positions(sensor);
  for (const auto& position : positions.colwise()) out << position.transpose() << "\n";
  return out.str();
}

struct Panel {
  int scene;
  int column;
  std::string file;    ///< of the image; empty for none
  std::string inside;  ///< written in its middle
  std::string below;
  std::string name;  ///< label and scene
};

/// A panel: its words, then the image with the electrodes on it.
void plot_panel(Canvas& canvas, const Layout& layout, const Panel& panel, int grid) {
  const int left = layout.left_of(panel.column);
  const int top = layout.top_of(panel.scene);
  const double middle = left + layout.panel / 2.0;
  canvas.area(left, top, layout.panel, layout.panel);
  if (!panel.inside.empty()) {
    canvas.label(panel.inside, middle, top + layout.panel / 2.0, 11, "center front");
  }
  if (!panel.below.empty()) {
    canvas.label(panel.below, middle, top + layout.panel + 8, 9, "center");
  }
  const std::string& result = panel.inside.empty() ? panel.below : panel.inside;
  canvas.tooltip(left, top, layout.panel, layout.panel,
                 panel.name + (result.empty() ? "" : "\n" + result));
  canvas.out() << "plot ";
  if (!panel.file.empty()) {
    const int points = kRepeat * grid;
    canvas.out() << gnuplot_string(panel.file) << " matrix using (-1 + 2 * ($1 + 0.5) / " << points
                 << "):(-1 + 2 * ($2 + 0.5) / " << points << "):3 with image, ";
  }
  canvas.out() << "'electrodes.txt' with points pointtype 7 pointsize 0.25 linecolor 'black'\n"
               << "unset label\n";
}

/// A strip of the palette with its ticks, as high as the first rows of panels.
void plot_colour_bar(Canvas& canvas, const Layout& layout, const ColourScale& scale) {
  constexpr int width = 11;
  const int left = layout.left_of(layout.columns) + 4;
  const int top = layout.top_of(0);
  const int height = layout.bar_height();
  const double range = scale.high - scale.low;
  const int steps = static_cast<int>(std::lround(range / scale.step));
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(scale.step) - 1e-9)));
  for (int i = 0; i <= steps; ++i) {
    const double y = top + height * (1 - double(i) / steps);
    std::string text = fixed(scale.low + i * scale.step, decimals);
    if (i == 0 && scale.below) text = "≤ " + text;
    if (i == steps && scale.above) text = "≥ " + text;
    canvas.label(text, left + width + 5, y, 10, "left");
    canvas.line(left + width, y, left + width + 3, y, "linecolor '#404040'");
  }
  const char* quantity = height > 170 ? "conductivity change δσ / c₀" : "δσ / c₀";
  canvas.label(quantity, left + width + 55, top + height / 2.0, 11, "center rotate by 90");
  canvas.area(left, top, width, height);
  canvas.out() << "unset object\nset xrange [0:1]\nset yrange [0:256]\n"
               << "set border linecolor '#404040'\n"
               << "plot 'bar.txt' matrix using (0.25 + 0.5 * $1):($2 + 0.5):3 with image\n";
}

void print_head(Canvas& canvas, const Layout& layout, const ColourScale& scale,
                const std::vector<std::string>& row_labels) {
  canvas.out() << palette_command() << "set multiplot\nunset key\nunset tics\nunset border\n"
               << "unset colorbox\nset cbrange [" << scale.low << ":" << scale.high << "]\n"
               << "set xrange [-1:1]\nset yrange [-1:1]\nset clip two\n"
               << "set object 1 rectangle from -1,-1 to 1,1 behind fillstyle solid "
                  "border linecolor '#808080' fillcolor '#e6e6e6'\n";
  for (int column = 0; column < layout.columns; ++column) {
    const auto& lines = layout.titles[static_cast<std::size_t>(column)];
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const double y =
          layout.top_of(0) - 4 - Layout::kLine * (static_cast<double>(lines.size() - i) - 0.5);
      canvas.label(lines[i], layout.left_of(column) + layout.panel / 2.0, y, 11, "center");
    }
  }
  const auto characters = static_cast<std::size_t>(layout.panel / 5.8);
  for (int scene = 0; scene < layout.scenes; ++scene) {
    canvas.label(one_line(row_labels[static_cast<std::size_t>(scene)], characters), 12,
                 layout.top_of(scene) + layout.panel / 2.0, 10, "center rotate by 90");
  }
}

std::string caption(const ReconstructionFigure& figure, const FigureColumn& column, int scene) {
  if (column.errors.empty()) return "";
  const auto& error = column.errors[static_cast<std::size_t>(scene)];
  return figure.error_name + " " + (error ? three_digits(*error) : "—");
}

}  // namespace

void draw_reconstruction_figure(const ReconstructionFigure& figure,
                                const std::filesystem::path& stem) {
  check(figure);
  const int grid = figure.sensor.image_grid;
  const double background = figure.sensor.background;
  const Images truth = figure.conductivity.array() / background - 1;
  std::vector<Images> columns;
  for (const FigureColumn& column : figure.columns) {
    columns.emplace_back(column.failure.empty() ? Images(column.changes / background) : Images());
  }
  const Layout layout = layout_for(figure);
  const ColourScale scale =
      colour_scale(truth, columns, std::clamp(layout.bar_height() / 18, 4, 9));

  FileContents files = {{"electrodes.txt", electrodes(figure.sensor)},
                        {"bar.txt", bar_file(scale)}};
  const auto store = [&](const auto& image) {
    std::string name = "image" + std::to_string(files.size()) + ".txt";
    files[name] = image_file(image, grid, scale);
    return name;
  };
  Canvas canvas(layout.width(), layout.height());
  print_head(canvas, layout, scale, figure.row_labels);
  for (int scene = 0; scene < layout.scenes; ++scene) {
    const std::string& scene_name = figure.row_labels[static_cast<std::size_t>(scene)];
    plot_panel(canvas, layout, {scene, 0, store(truth.row(scene)), "", "", "truth, " + scene_name},
               grid);
    for (int c = 1; c < layout.columns; ++c) {
      const FigureColumn& column = figure.columns[static_cast<std::size_t>(c - 1)];
      Panel panel{scene, c, "", column.failure, "", column.label + ", " + scene_name};
      if (column.failure.empty()) {
        const auto image = columns[static_cast<std::size_t>(c - 1)].row(scene);
        panel.file = store(image);
        if (!image.array().isFinite().any()) panel.inside = "undefined";
        panel.below = caption(figure, column, scene);
      }
      plot_panel(canvas, layout, panel, grid);
    }
  }
  plot_colour_bar(canvas, layout, scale);
  canvas.out() << "unset multiplot\n";
  canvas.draw(files, stem);
}

}  // namespace ertbench
