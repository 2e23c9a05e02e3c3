#include "bench/charts/images_figure.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/plot/axis.h"
#include "bench/plot/colour_scale.h"
#include "bench/plot/image_panel.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr int most_across = 4;
constexpr double panel_side =
    190;  ///< of the sheet's longer side, px; a single image's is twice that
constexpr double gap = 10;
constexpr double caption = 20;  ///< below each panel
constexpr double border = 8;
constexpr double bar_room = 96;    ///< of the colour bar with its title
constexpr double scale_room = 26;  ///< of the bar in mm

/// A round number of millimetres, about a quarter of the sheet.
double scale_length(double width_mm) {
  const double step = round_step(width_mm, 4);
  return step > width_mm / 2 ? step / 2 : step;
}

}  // namespace

void draw_images_figure(const Sensor& sensor, const Images& changes,
                        const std::vector<std::string>& labels, const std::filesystem::path& stem) {
  const auto count = static_cast<int>(changes.rows());
  if (count < 1 || changes.cols() != sensor.pixels() ||
      labels.size() != static_cast<std::size_t>(count)) {
    throw std::invalid_argument("figure of images: sizes do not fit together");
  }
  const Images shown = changes / sensor.background;
  const Eigen::Vector2d size_mm = sensor.sheet->size_mm();
  const double px_per_mm = panel_side * (count == 1 ? 2 : 1) / size_mm.maxCoeff();
  const Eigen::Vector2d panel = px_per_mm * size_mm;
  const int across = std::min(count, most_across);
  const int down = (count + across - 1) / across;
  const double images_width = across * panel.x() + (across - 1) * gap;
  const double images_height = down * (panel.y() + caption);

  Canvas canvas(2 * border + images_width + bar_room, 2 * border + images_height + scale_room);
  ImagePanels panels(canvas, sensor, colour_scale(shown, {}, 8));
  for (int i = 0; i < count; ++i) {
    const Box box = Box::sized(border + i % across * (panel.x() + gap),
                               border + static_cast<double>(i / across) * (panel.y() + caption),
                               panel.x(), panel.y());
    const Eigen::RowVectorXd image = shown.row(i);
    panels.image(box, image, image.array().isFinite().any() ? "" : "undefined");
    canvas.text(labels[static_cast<std::size_t>(i)], box.middle(), box.bottom + 9, {.size = 10});
  }
  const double bar_height = std::min(images_height - caption, 2 * panel.y());
  panels.colour_bar(
      Box::sized(border + images_width + 14, border, ImagePanels::bar_width, bar_height),
      bar_height > 170 ? "conductivity change δσ / c₀" : "δσ / c₀");

  const double length_mm = scale_length(size_mm.x());
  const double y = border + images_height + 6;
  const double right = border + length_mm * px_per_mm;
  canvas.line(border, y, right, y, {.width = 2.5});
  for (const double end : {border, right}) canvas.line(end, y - 4, end, y + 4, {.width = 1.5});
  canvas.text(number_text(length_mm) + " mm", right + 6, y, {.size = 10, .align = TextAlign::left});
  canvas.draw(stem);
}

}  // namespace ertbench
