#include "bench/report/reconstruction_figure.h"

#include <algorithm>
#include <stdexcept>

#include "bench/plot/image_panel.h"
#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr int most_solvers = 9;  ///< side by side, beside the truth

/// Where an image stands: the columns are broken into bands below each other, of which each begins
/// with the truth.
struct Place {
  int band;
  int column;  ///< in its band, 0 the truth
  int scene;
};

/// Places and sizes in px from the top left corner; panels are squares.
struct SceneLayout {
  int scenes;
  int solvers;
  int bands;
  int columns;  ///< of a band, with the truth
  int panel;
  std::vector<std::vector<std::string>> titles;  ///< of the truth, then of the solvers

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
  int band_height() const { return title_height() + 4 + scenes * (panel + kCaption); }
  int height() const { return 2 * kBorder + bands * band_height() - 4; }
  int bar_height() const { return std::min(scenes, 3) * (panel + kCaption) - kCaption; }
  int left_of(int column) const { return kLeft + column * (panel + kGap); }
  Box box(const Place& place) const {
    return Box::sized(left_of(place.column), top_of(place.band, place.scene), panel, panel);
  }
  int top_of(int band, int scene) const {
    return kBorder + band * band_height() + title_height() + 4 + scene * (panel + kCaption);
  }
  Place place_of(int solver, int scene) const {
    return {solver / (columns - 1), 1 + solver % (columns - 1), scene};
  }
};

SceneLayout scene_layout_for(const ReconstructionFigure& figure) {
  constexpr int widest = 950;  // px of all panels and gaps
  constexpr int max_lines = 3;
  SceneLayout layout{};
  layout.scenes = static_cast<int>(figure.conductivity.rows());
  layout.solvers = static_cast<int>(figure.columns.size());
  layout.bands = std::max(1, (layout.solvers + most_solvers - 1) / most_solvers);
  // As many in each band, but for what the last one lacks.
  layout.columns = 1 + (layout.solvers + layout.bands - 1) / layout.bands;
  layout.panel = std::clamp(widest / layout.columns - SceneLayout::kGap, 92, 145);
  const auto characters = characters_in(layout.panel, 11);
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

void print_title(Canvas& canvas, const SceneLayout& layout, const Place& place,
                 const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double y = layout.top_of(place.band, 0) - 4 -
                     SceneLayout::kLine * (static_cast<double>(lines.size() - i) - 0.5);
    canvas.text(lines[i], layout.box(place).middle(), y, {.size = 11});
  }
}

void print_titles(Canvas& canvas, const SceneLayout& layout,
                  const std::vector<std::string>& row_labels) {
  const auto characters = characters_in(layout.panel, 10);
  for (int band = 0; band < layout.bands; ++band) {
    print_title(canvas, layout, {band, 0, 0}, layout.titles.front());
    for (int scene = 0; scene < layout.scenes; ++scene) {
      canvas.text(one_line(row_labels[static_cast<std::size_t>(scene)], characters), 12,
                  layout.box({band, 0, scene}).centre(), {.upright = true});
    }
  }
  for (int solver = 0; solver < layout.solvers; ++solver) {
    print_title(canvas, layout, layout.place_of(solver, 0),
                layout.titles[static_cast<std::size_t>(solver) + 1]);
  }
}

std::string caption(const FigureColumn& column, int scene) {
  if (column.errors.empty()) return "";
  const auto& error = column.errors[static_cast<std::size_t>(scene)];
  return "rel. error " + (error ? three_digits(*error) : "—");
}

}  // namespace

void draw_reconstruction_figure(const ReconstructionFigure& figure,
                                const std::filesystem::path& stem) {
  check(figure);
  const double background = figure.sensor.background;
  const Images truth = figure.conductivity.array() / background - 1;
  std::vector<Images> columns;
  for (const FigureColumn& column : figure.columns) {
    columns.emplace_back(column.failure.empty() ? Images(column.changes / background) : Images());
  }
  const SceneLayout layout = scene_layout_for(figure);
  const ColourScale scale =
      colour_scale(truth, columns, std::clamp(layout.bar_height() / 18, 4, 9));

  Canvas canvas(layout.width(), layout.height());
  ImagePanels panels(canvas, figure.sensor, scale);
  print_titles(canvas, layout, figure.row_labels);
  // The words of a panel, then the image [pixels] with the electrodes on it.
  const auto plot = [&](const Place& place, const std::string& name, const std::string& inside,
                        const std::string& below, const Eigen::RowVectorXd& image) {
    const Box box = layout.box(place);
    if (!below.empty()) canvas.text(below, box.middle(), box.bottom + 8, {.size = 9});
    const std::string& result = inside.empty() ? below : inside;
    canvas.tooltip(box, name + (result.empty() ? "" : "\n" + result));
    panels.image(box, image, inside);
  };
  for (int scene = 0; scene < layout.scenes; ++scene) {
    const std::string& scene_name = figure.row_labels[static_cast<std::size_t>(scene)];
    const std::string unknown = figure.truth_is_known ? "" : "unknown";
    const Eigen::RowVectorXd true_image =
        figure.truth_is_known ? Eigen::RowVectorXd(truth.row(scene)) : Eigen::RowVectorXd();
    for (int band = 0; band < layout.bands; ++band) {
      plot({band, 0, scene}, "truth, " + scene_name, unknown, "", true_image);
    }
    for (int c = 0; c < layout.solvers; ++c) {
      const FigureColumn& column = figure.columns[static_cast<std::size_t>(c)];
      std::string inside = column.failure;
      std::string below;
      Eigen::RowVectorXd image;
      if (column.failure.empty()) {
        image = columns[static_cast<std::size_t>(c)].row(scene);
        if (!image.array().isFinite().any()) inside = "undefined";
        below = caption(column, scene);
      }
      plot(layout.place_of(c, scene), column.label + ", " + scene_name, inside, below, image);
    }
  }
  panels.scale_bar(layout.box({0, 0, 0}));
  panels.colour_bar(Box::sized(layout.left_of(layout.columns) + 4, layout.top_of(0, 0),
                               ImagePanels::bar_width, layout.bar_height()),
                    "δσ / background");
  canvas.draw(stem);
}

}  // namespace ertbench
