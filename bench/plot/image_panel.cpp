#include "bench/plot/image_panel.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "bench/plot/palette.h"
#include "core/text.h"

namespace ertbench {
namespace {

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

/// The sheet as an object of gnuplot.
std::string outline(const Sheet& sheet) {
  std::ostringstream out;
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
      high_(sensor.sheet->bounds().max()) {
  files_ = {{"electrodes.txt", electrodes(sensor)}, {"bar.txt", bar_file(scale)}};
  canvas_.out() << palette_command() << "unset key\nunset tics\nunset border\n"
                << "unset colorbox\nset cbrange [" << scale.low << ":" << scale.high << "]\n"
                << "set xrange [" << low_.x() << ":" << high_.x() << "]\nset yrange [" << low_.y()
                << ":" << high_.y() << "]\nset clip two\n"
                << "set object 1 " << outline(*sensor.sheet)
                << " behind fillstyle solid border linecolor '#808080' fillcolor '#e6e6e6'\n";
}

void ImagePanels::image(double left, double top, double side,
                        const Eigen::Ref<const Eigen::RowVectorXd>& values,
                        const std::string& inside) {
  canvas_.area(left, top, side, side);
  if (!inside.empty()) {
    canvas_.label(inside, left + side / 2, top + side / 2, 11, "center front");
  }
  canvas_.out() << "plot ";
  if (values.size() > 0) {
    const std::string file = "image" + std::to_string(files_.size()) + ".txt";
    files_[file] = image_file(values, grid_, scale_);
    const int points = kRepeat * grid_;
    canvas_.out() << gnuplot_string(file) << " matrix using (" << low_.x() << " + "
                  << high_.x() - low_.x() << " * ($1 + 0.5) / " << points << "):(" << low_.y()
                  << " + " << high_.y() - low_.y() << " * ($2 + 0.5) / " << points
                  << "):3 with image, ";
  }
  canvas_.out() << "'electrodes.txt' with points pointtype 7 pointsize 0.25 linecolor 'black'\n"
                << "unset label\n";
}

void ImagePanels::colour_bar(double left, double top, double height, const std::string& quantity) {
  constexpr int width = 11;
  const double range = scale_.high - scale_.low;
  const int steps = static_cast<int>(std::lround(range / scale_.step));
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(scale_.step) - 1e-9)));
  for (int i = 0; i <= steps; ++i) {
    const double y = top + height * (1 - double(i) / steps);
    std::string text = fixed(scale_.low + i * scale_.step, decimals);
    if (i == 0 && scale_.below) text = "≤ " + text;
    if (i == steps && scale_.above) text = "≥ " + text;
    canvas_.label(text, left + width + 5, y, 10, "left");
    canvas_.line(left + width, y, left + width + 3, y, "linecolor '#404040'");
  }
  canvas_.label(quantity, left + width + 55, top + height / 2.0, 11, "center rotate by 90");
  canvas_.area(left, top, width, height);
  canvas_.out() << "unset object\nset xrange [0:1]\nset yrange [0:256]\n"
                << "set border linecolor '#404040'\n"
                << "plot 'bar.txt' matrix using (0.25 + 0.5 * $1):($2 + 0.5):3 with image\n";
}

}  // namespace ertbench
