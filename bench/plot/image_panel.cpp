#include "bench/plot/image_panel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/text.h"

namespace ertbench {

void draw_colour_bar(Canvas& canvas, const Box& box, const Axis& axis, Palette palette) {
  constexpr int size = 10;
  constexpr int steps = 256;
  double widest = 0;
  for (const Tick& tick : axis.ticks) {
    const double y = box.up(axis.share(tick.value));
    canvas.line(box.right, y, box.right + 3, y, {});
    canvas.text(tick.text, box.right + 5, y, {.size = size, .align = TextAlign::left});
    widest = std::max(widest, text_width(tick.text, size));
  }
  if (!axis.title.empty()) {
    canvas.text(axis.title, box.right + 17 + widest, box.centre(), {.size = 11, .upright = true});
  }
  TextStream strip;
  for (int i = 0; i < steps; ++i) {
    const double value = axis.low + (axis.high - axis.low) * (i + 0.5) / steps;
    strip << value << ' ' << value << '\n';
  }
  canvas.area(box);
  canvas.plots() << palette_command(palette)
                 << "unset key\nunset tics\nunset colorbox\nset cbrange [" << axis.low << ":"
                 << axis.high << "]\nset xrange [0:1]\nset yrange [0:" << steps
                 << "]\nset border 15 linecolor '#404040'\nplot " << canvas.data(strip.str())
                 << " matrix using (0.25 + 0.5 * $1):($2 + 0.5):3 with image\nunset border\n";
}

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

constexpr int most_across = 4;
constexpr double panel_side =
    190;  ///< of the sheet's longer side, px; a single image's is twice that
constexpr double gap = 10;
constexpr double caption_height = 20;  ///< below each panel
constexpr double border = 8;
constexpr double bar_room = 96;    ///< of the colour bar with its title
constexpr double scale_room = 26;  ///< of the bar in mm

/// A round number of millimetres, about a quarter of the sheet.
double scale_length(double width_mm) {
  const double step = round_step(width_mm, 4);
  return step > width_mm / 2 ? step / 2 : step;
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
  const double images_height = down * (panel.y() + caption_height);

  Canvas canvas(2 * border + images_width + bar_room, 2 * border + images_height + scale_room);
  ImagePanels panels(canvas, sensor, colour_scale(shown, {}, 8));
  for (int i = 0; i < count; ++i) {
    const Box box =
        Box::sized(border + i % across * (panel.x() + gap),
                   border + static_cast<double>(i / across) * (panel.y() + caption_height),
                   panel.x(), panel.y());
    const Eigen::RowVectorXd image = shown.row(i);
    panels.image(box, image, image.array().isFinite().any() ? "" : "undefined");
    canvas.text(labels[static_cast<std::size_t>(i)], box.middle(), box.bottom + 9, {.size = 10});
  }
  const double bar_height = std::min(images_height - caption_height, 2 * panel.y());
  panels.colour_bar(
      Box::sized(border + images_width + 14, border, ImagePanels::bar_width, bar_height),
      "δσ / background");

  const double length_mm = scale_length(size_mm.x());
  const double y = border + images_height + 6;
  const double right = border + length_mm * px_per_mm;
  canvas.line(border, y, right, y, {.width = 2.5});
  for (const double end : {border, right}) canvas.line(end, y - 4, end, y + 4, {.width = 1.5});
  canvas.text(number_text(length_mm) + " mm", right + 6, y, {.size = 10, .align = TextAlign::left});
  canvas.draw(stem);
}

}  // namespace ertbench
