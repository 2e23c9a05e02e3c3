#include "bench/plot/style.h"

#include <algorithm>
#include <iterator>

#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

/// Of a character, as a part of the font's size.
constexpr double character_width = 0.58;

std::string quoted(const Colour& colour) { return "'" + colour.hex() + "'"; }

}  // namespace

std::string LineStyle::text() const {
  TextStream out;  // the colour first: a rectangle's border knows no other order
  out << "linecolor rgb " << quoted(colour) << " linewidth " << width << " dashtype " << dash;
  return out.str();
}

std::string MarkStyle::text() const {
  TextStream out;
  out << "pointtype " << shape << " pointsize " << size << " linewidth " << width
      << " linecolor rgb " << quoted(colour);
  return out.str();
}

int filled(std::size_t index) { return shapes[index % std::size(shapes)]; }

std::string BoxStyle::text() const {
  std::string out = front ? "front " : "";
  out += fill ? "fillcolor rgb " + quoted(*fill) + " fillstyle solid " : "fillstyle empty ";
  return out + (border ? "border " + border->text() : "noborder");
}

std::string TextStyle::text() const {
  const char* sides[] = {"left", "center", "right"};
  return std::string(sides[static_cast<int>(align)]) + (upright ? " rotate by 90" : "") +
         " front textcolor rgb " + quoted(colour) + (boxed ? " boxed" : "");
}

double text_width(const std::string& text, int size) {
  return character_width * size * static_cast<double>(character_count(text));
}

std::size_t characters_in(double width, int size) {
  return static_cast<std::size_t>(std::max(1.0, width / (character_width * size)));
}

}  // namespace ertbench
