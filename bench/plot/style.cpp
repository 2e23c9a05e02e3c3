#include "bench/plot/style.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

/// Of a character as a rule, as a part of the font's size.
constexpr double character_width = 0.58;

/// The same of one character, as DejaVu Sans has it, which is wider than most.
double width_of(char c) {
  constexpr std::string_view narrow = "ijl I.,:;'|!()[]";
  constexpr std::string_view slender = "frt-/\"";
  constexpr std::string_view wide = "mwMW=+<>%@";
  const auto in = [c](std::string_view group) { return group.find(c) != group.npos; };
  return in(narrow) ? 0.34 : in(slender) ? 0.42 : in(wide) ? 0.93 : 0.63;
}

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

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
  double width = 0;
  for (const char c : text) {
    if (!continues_character(c)) width += width_of(c);
  }
  // Not less than characters_in() counts on, so that a word that fits is not broken by it.
  return std::max(width, character_width * static_cast<double>(character_count(text))) * size;
}

std::size_t characters_in(double width, int size) {
  return static_cast<std::size_t>(std::max(1.0, width / (character_width * size)));
}

}  // namespace ertbench
