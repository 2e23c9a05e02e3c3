#include "bench/plot/canvas.h"

#include <utility>

#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

std::string margins(const Box& box, double width, double height) {
  TextStream out;
  out.precision(10);
  out << "set lmargin at screen " << box.left / width << "\nset rmargin at screen "
      << box.right / width << "\nset tmargin at screen " << 1 - box.top / height
      << "\nset bmargin at screen " << 1 - box.bottom / height << "\n";
  return out.str();
}

}  // namespace

Canvas::Canvas(double width, double height)
    : width_(static_cast<int>(width)), height_(static_cast<int>(height)) {
  plots_.precision(10);
  marks_.precision(10);
}

std::string Canvas::screen(double x, double y) const {
  TextStream place;
  place.precision(10);
  place << "screen " << x / width_ << ", screen " << 1 - y / height_;
  return place.str();
}

void Canvas::text(const std::string& text, double x, double y, const TextStyle& style) {
  marks_ << "set label " << gnuplot_string(text) << " at " << screen(x, y) << " font ',"
         << style.size << "' " << style.text() << "\n";
}

void Canvas::lines(const std::string& text, std::size_t characters, double x, double y,
                   const TextStyle& style) {
  for (const std::string& line : wrapped(text, characters)) {
    this->text(line, x, y, style);
    y += style.size + 2;
  }
}

void Canvas::title(const std::string& text) {
  constexpr int size = 12;
  this->text(one_line(text, characters_in(width_, size)), width_ / 2.0, 16, {.size = size});
}

void Canvas::letter(int index, double y) {
  const std::string text = std::string("(") + static_cast<char>('a' + index % 26) + ")";
  this->text(text, 14, y, {.size = 12, .align = TextAlign::left});
}

void Canvas::line(double x1, double y1, double x2, double y2, const LineStyle& style) {
  marks_ << "set arrow from " << screen(x1, y1) << " to " << screen(x2, y2) << " nohead "
         << style.text() << "\n";
}

void Canvas::rectangle(const Box& box, const BoxStyle& style) {
  marks_ << "set object rectangle from " << screen(box.left, box.bottom) << " to "
         << screen(box.right, box.top) << " " << style.text() << "\n";
}

void Canvas::mark(double x, double y, const MarkStyle& style) {
  marks_ << "set label \"\" at " << screen(x, y) << " point " << style.text() << "\n";
}

void Canvas::tooltip(const Box& box, std::string text) {
  tooltips_.push_back({box, std::move(text)});
}

void Canvas::tooltip_at(double x, double y, std::string text) {
  constexpr double reach = 6;
  tooltip(Box::around(x, y, reach), std::move(text));
}

void Canvas::area(const Box& box) { plots_ << margins(box, width_, height_); }

std::string Canvas::data(const std::string& text) {
  const std::string name = "data" + std::to_string(files_.size()) + ".txt";
  files_[name] = text;
  return "'" + name + "'";
}

void Canvas::draw(const std::filesystem::path& stem) const {
  // The marks belong to a last plot, of nothing, over the whole picture.
  const std::string commands =
      "set multiplot\nset style textbox opaque noborder fillcolor 'white' margins 0.3,0.3\n" +
      plots_.str() + margins({0, 0, double(width_), double(height_)}, width_, height_) +
      "unset key\nunset tics\nunset border\nset xrange [0:1]\nset yrange [0:1]\n" + marks_.str() +
      "plot NaN notitle\nunset multiplot\n";
  draw_chart(commands, files_, width_, height_, stem, tooltips_);
}

}  // namespace ertbench
