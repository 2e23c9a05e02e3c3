#include "bench/plot/image_panel.h"

#include <algorithm>
#include <cmath>

#include "bench/plot/colour_bar.h"
#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

/// Every pixel is written as a square of this many: some viewers of SVG smooth the pictures in it,
/// which then blurs the edges of the pixels only.
constexpr int kRepeat = 4;

/// A data file: a matrix, row 0 first.
std::string image_file(const Eigen::Ref<const Eigen::RowVectorXd>& image, int grid,
                       const ColourScale& scale) {
  TextStream out;
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

std::string electrodes(const Sensor& sensor) {
  TextStream out;
  const Eigen::Matrix2Xd positions = electrode_positions(sensor);
  for (const auto& position : positions.colwise()) out << position.transpose() << "\n";
  return out.str();
}

/// The sheet as an object of gnuplot.
std::string outline(const Sheet& sheet) {
  TextStream out;
  if (sheet.fills_bounds()) {
    const Eigen::Vector2d low = sheet.bounds().min();
    const Eigen::Vector2d high = sheet.bounds().max();
    out << "rectangle from " << low.x() << "," << low.y() << " to " << high.x() << "," << high.y();
    return out.str();
  }
  constexpr int points = 180;
  for (int i = 0; i <= points; ++i) {
    const Eigen::Vector2d at = sheet.border_point(sheet.border_length() * i / points);
    out << (i == 0 ? "polygon from " : " to ") << at.x() << "," << at.y();
  }
  return out.str();
}

}  // namespace

ImagePanels::ImagePanels(Canvas& canvas, const Sensor& sensor, const ColourScale& scale)
    : canvas_(canvas),
      scale_(scale),
      grid_(sensor.image_grid),
      low_(sensor.sheet->bounds().min()),
      high_(sensor.sheet->bounds().max()),
      outline_(outline(*sensor.sheet)),
      electrodes_(canvas.data(electrodes(sensor))) {}

void ImagePanels::image(const Box& box, const Eigen::Ref<const Eigen::RowVectorXd>& values,
                        const std::string& inside) {
  canvas_.area(box);
  std::ostream& out = canvas_.plots();
  out << palette_command() << "unset key\nunset tics\nunset border\nunset colorbox\n"
      << "set cbrange [" << scale_.low << ":" << scale_.high << "]\n"
      << "set xrange [" << low_.x() << ":" << high_.x() << "]\nset yrange [" << low_.y() << ":"
      << high_.y() << "]\nset clip two\nset object 1 " << outline_
      << " behind fillstyle solid border linecolor '#808080' fillcolor '#e6e6e6'\nplot ";
  if (values.size() > 0) {
    const int points = kRepeat * grid_;
    out << canvas_.data(image_file(values, grid_, scale_)) << " matrix using (" << low_.x() << " + "
        << high_.x() - low_.x() << " * ($1 + 0.5) / " << points << "):(" << low_.y() << " + "
        << high_.y() - low_.y() << " * ($2 + 0.5) / " << points << "):3 with image, ";
  }
  out << electrodes_ << " with points pointtype 7 pointsize 0.25 linecolor 'black'\n"
      << "unset object 1\n";
  if (!inside.empty()) canvas_.text(inside, box.middle(), box.centre(), {.size = 11});
}

void ImagePanels::colour_bar(const Box& box, const std::string& quantity) {
  const int steps = static_cast<int>(std::lround((scale_.high - scale_.low) / scale_.step));
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(scale_.step) - 1e-9)));
  Axis axis{scale_.low, scale_.high};
  axis.title = quantity;
  for (int i = 0; i <= steps; ++i) {
    const double value = scale_.low + i * scale_.step;
    const bool below = i == 0 && scale_.below;
    const bool above = i == steps && scale_.above;
    axis.ticks.push_back({value, (below ? "≤ " : above ? "≥ " : "") + fixed(value, decimals)});
  }
  draw_colour_bar(canvas_, box, axis);
}

}  // namespace ertbench
