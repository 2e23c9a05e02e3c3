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
std::string image_file(const Eigen::Ref<const Eigen::RowVectorXd>& image, const PixelGrid& pixels,
                       const ColourScale& scale) {
  TextStream out;
  for (int row = 0; row < pixels.rows() * kRepeat; ++row) {
    for (int column = 0; column < pixels.columns() * kRepeat; ++column) {
      const int pixel = column / kRepeat + pixels.columns() * (row / kRepeat);
      const double value = image[pixel];
      if (std::isfinite(value) && pixels.on_sheet(pixel)) {
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

/// The largest box in the middle of `box` that has the sheet's proportions.
Box in_proportion(const Box& box, const Eigen::Vector2d& sides) {
  const double scale = std::min(box.width() / sides.x(), box.height() / sides.y());
  const Eigen::Vector2d size = scale * sides;
  return Box::sized(box.middle() - size.x() / 2, box.centre() - size.y() / 2, size.x(), size.y());
}

}  // namespace

ImagePanels::ImagePanels(Canvas& canvas, const Sensor& sensor, const ColourScale& scale)
    : canvas_(canvas),
      scale_(scale),
      palette_(scale.low < 0 && scale.high == -scale.low ? Palette::diverging
                                                         : Palette::sequential),
      pixels_(sensor.image()),
      unit_mm_(sensor.sheet->unit_mm()),
      low_(sensor.sheet->bounds().min()),
      high_(sensor.sheet->bounds().max()),
      outline_(outline(*sensor.sheet)),
      electrodes_(canvas.data(electrodes(sensor))) {}

void ImagePanels::image(const Box& box, const Eigen::Ref<const Eigen::RowVectorXd>& values,
                        const std::string& inside) {
  canvas_.area(in_proportion(box, high_ - low_));
  std::ostream& out = canvas_.plots();
  out << palette_command(palette_) << "unset key\nunset tics\nunset border\nunset colorbox\n"
      << "set cbrange [" << scale_.low << ":" << scale_.high << "]\n"
      << "set xrange [" << low_.x() << ":" << high_.x() << "]\nset yrange [" << low_.y() << ":"
      << high_.y() << "]\nset clip two\nset object 1 " << outline_
      << " behind fillstyle solid border linecolor '#808080' fillcolor '#e6e6e6'\n";
  // Over pixels that the border cuts.
  if (!pixels_.all_on_sheet()) {
    out << "set object 2 " << outline_ << " front fillstyle empty border linecolor '#404040'\n";
  }
  out << "plot ";
  if (values.size() > 0) {
    out << canvas_.data(image_file(values, pixels_, scale_)) << " matrix using (" << low_.x()
        << " + " << high_.x() - low_.x() << " * ($1 + 0.5) / " << kRepeat * pixels_.columns()
        << "):(" << low_.y() << " + " << high_.y() - low_.y() << " * ($2 + 0.5) / "
        << kRepeat * pixels_.rows() << "):3 with image, ";
  }
  out << electrodes_ << " with points pointtype 7 pointsize 0.25 linecolor 'black'\n"
      << "unset object 1\n";
  if (!pixels_.all_on_sheet()) out << "unset object 2\n";
  if (!inside.empty()) canvas_.text(inside, box.middle(), box.centre(), {.size = 11});
}

void ImagePanels::scale_bar(const Box& box) {
  const double across_mm = unit_mm_ * (high_.x() - low_.x());
  const double length_mm = round_step(across_mm, 3);
  const double y = box.bottom + 8;
  const double right = box.left + box.width() * length_mm / across_mm;
  const LineStyle line{ink::black, 1.5};
  canvas_.line(box.left, y, right, y, line);
  for (const double x : {box.left, right}) canvas_.line(x, y - 3, x, y + 3, line);
  canvas_.text(number_text(length_mm) + " mm", right + 4, y, {.size = 9, .align = TextAlign::left});
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
  draw_colour_bar(canvas_, box, axis, palette_);
}

}  // namespace ertbench
