#include "bench/plot/canvas.h"

#include <utility>

#include "core/text.h"

namespace ertbench {

Canvas::Canvas(int width, int height) : width_(width), height_(height) { out_.precision(10); }

std::string Canvas::screen(double x, double y) const {
  std::ostringstream place;
  place.precision(10);
  place << "screen " << x / width_ << ", screen " << 1 - y / height_;
  return place.str();
}

void Canvas::label(const std::string& text, double x, double y, int size,
                   const std::string& options) {
  out_ << "set label " << gnuplot_string(text) << " at " << screen(x, y) << " font '," << size
       << "' " << options << "\n";
}

void Canvas::lines(const std::string& text, std::size_t characters, double x, double y, int size) {
  for (const std::string& line : wrapped(text, characters)) {
    label(line, x, y, size, "center");
    y += size + 2;
  }
}

void Canvas::line(double x1, double y1, double x2, double y2, const std::string& style) {
  out_ << "set arrow from " << screen(x1, y1) << " to " << screen(x2, y2) << " nohead " << style
       << "\n";
}

void Canvas::rectangle(double left, double top, double width, double height,
                       const std::string& style) {
  out_ << "set object rectangle from " << screen(left, top + height) << " to "
       << screen(left + width, top) << " " << style << "\n";
}

void Canvas::area(double left, double top, double width, double height) {
  out_ << "set lmargin at screen " << left / width_ << "\nset rmargin at screen "
       << (left + width) / width_ << "\nset tmargin at screen " << 1 - top / height_
       << "\nset bmargin at screen " << 1 - (top + height) / height_ << "\n";
}

void Canvas::finish_marks() {
  area(0, 0, width_, height_);
  out_ << "unset key\nunset tics\nunset border\nset xrange [0:1]\nset yrange [0:1]\n"
       << "plot NaN notitle\nunset label\nunset arrow\nunset object\n";
}

void Canvas::tooltip(double left, double top, double width, double height, std::string text) {
  tooltips_.push_back({left, top, width, height, std::move(text)});
}

void Canvas::tooltip_at(double x, double y, std::string text) {
  constexpr double reach = 6;
  tooltip(x - reach, y - reach, 2 * reach, 2 * reach, std::move(text));
}

void Canvas::draw(const FileContents& inputs, const std::filesystem::path& stem) const {
  draw_chart(text(), inputs, width_, height_, stem, tooltips_);
}

}  // namespace ertbench
