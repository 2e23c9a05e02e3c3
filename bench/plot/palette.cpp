#include "bench/plot/palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <span>
#include <string_view>

#include "bench/plot/panel.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::array kViridis = {rgb(0x440154), rgb(0x482878), rgb(0x3e4a89), rgb(0x31688e),
                                 rgb(0x26828e), rgb(0x1f9e89), rgb(0x35b779), rgb(0x6ece58),
                                 rgb(0xb5de2b), rgb(0xfde725)};

// RdBu of ColorBrewer (Brewer et al. 2003), reversed: distinguishable with any colour vision.
constexpr std::array kBlueToRed = {rgb(0x053061), rgb(0x2166ac), rgb(0x4393c3), rgb(0x92c5de),
                                   rgb(0xd1e5f0), rgb(0xf7f7f7), rgb(0xfddbc7), rgb(0xf4a582),
                                   rgb(0xd6604d), rgb(0xb2182b), rgb(0x67001f)};

constexpr std::array kHues = {rgb(0x0072b2), rgb(0xd55e00), rgb(0x009e73), rgb(0xcc79a7),
                              rgb(0xe69f00), rgb(0x56b4e9), rgb(0x000000)};

Colour mixed(const Colour& a, const Colour& b, double share) {
  const auto part = [share](double x, double y) { return x + share * (y - x); };
  return {part(a.red, b.red), part(a.green, b.green), part(a.blue, b.blue)};
}

/// The share of light that a part stands for (sRGB).
double linear(double part) {
  return part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4);
}

/// Typical width of a character, relative to the font size.
constexpr double character_width = 0.58;

/// Width of one character in DejaVu Sans, which is wider than most fonts.
double width_of(char c) {
  constexpr std::string_view narrow = "ijl I.,:;'|!()[]";
  constexpr std::string_view slender = "frt-/\"";
  constexpr std::string_view wide = "mwMW=+<>%@";
  const auto in = [c](std::string_view group) { return group.find(c) != group.npos; };
  return in(narrow) ? 0.34 : in(slender) ? 0.42 : in(wide) ? 0.93 : 0.63;
}

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U; }

std::string quoted(const Colour& colour) { return "'" + colour.hex() + "'"; }

void extend(Span& span, const Images& images) {
  for (const double value : images.reshaped()) {
    if (std::isfinite(value)) span.extend(value);
  }
}

}  // namespace

std::string Colour::hex() const {
  char text[16];
  std::snprintf(text, sizeof text, "#%06x", static_cast<unsigned>(number()));
  return text;
}

int Colour::number() const {
  const auto byte = [](double part) {
    return static_cast<int>(std::lround(255 * std::clamp(part, 0.0, 1.0)));
  };
  return byte(red) * 0x10000 + byte(green) * 0x100 + byte(blue);
}

double Colour::lightness() const {
  const double light = 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
  return light > 0.008856 ? 1.16 * std::cbrt(light) - 0.16 : 9.033 * light;
}

Colour Colour::towards_black(double fraction) const { return mixed(*this, {0, 0, 0}, fraction); }
Colour Colour::towards_white(double fraction) const { return mixed(*this, {1, 1, 1}, fraction); }

Colour Colour::for_text() const {
  constexpr double lightest = 0.49;
  Colour out = *this;
  while (out.lightness() > lightest) out = out.towards_black(0.05);
  return out;
}

Colour viridis(double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * (kViridis.size() - 1);
  const auto below = std::min(static_cast<std::size_t>(place), kViridis.size() - 2);
  return mixed(kViridis[below], kViridis[below + 1], place - static_cast<double>(below));
}

std::string palette_command(Palette palette) {
  const std::span<const Colour> colours =
      palette == Palette::sequential ? std::span<const Colour>(kViridis) : kBlueToRed;
  std::string out = "set palette defined (";
  for (std::size_t i = 0; i < colours.size(); ++i) {
    out += (i > 0 ? ", " : "") + std::to_string(i) + " '" + colours[i].hex() + "'";
  }
  return out + ")\n";
}

Colour hue(std::size_t index) {
  static_assert(kHues.size() == hues);
  return kHues[index % hues];
}

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

ColourScale colour_scale(const Images& truth, const std::vector<Images>& estimates, int ticks) {
  constexpr double slack = 1e-6;  // of a step, against rounding
  Span shown{0, 0};
  extend(shown, truth);
  Span all = shown;
  for (const Images& images : estimates) extend(all, images);

  const double span = shown.high - shown.low;
  if (span > 0) {
    shown.low = std::max(all.low, shown.low - (shown.low < 0 ? 0.5 : 0.25) * span);
    shown.high = std::min(all.high, shown.high + (shown.high > 0 ? 0.5 : 0.25) * span);
  } else {
    shown = all;  // a blank truth: whatever a solver shows is an artefact
  }
  if (shown.high - shown.low < 1e-9) shown = {-0.1, 0.1};

  ColourScale scale;
  const double most = std::max(-shown.low, shown.high);
  scale.step = round_step(2 * most, ticks);
  scale.high = scale.step * std::ceil(most / scale.step - slack);
  scale.low = -scale.high;
  scale.below = all.low < scale.low - slack * scale.step;
  scale.above = all.high > scale.high + slack * scale.step;
  return scale;
}

}  // namespace ertbench
