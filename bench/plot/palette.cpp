#include "bench/plot/palette.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <span>

namespace ertbench {
namespace {

constexpr std::array kViridis = {rgb(0x440154), rgb(0x482878), rgb(0x3e4a89), rgb(0x31688e),
                                 rgb(0x26828e), rgb(0x1f9e89), rgb(0x35b779), rgb(0x6ece58),
                                 rgb(0xb5de2b), rgb(0xfde725)};

// RdBu of ColorBrewer (Brewer et al. 2003), reversed: told apart with any kind of colour vision.
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

Colour Colour::towards_black(double fraction) const {
  return {red * (1 - fraction), green * (1 - fraction), blue * (1 - fraction)};
}

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

}  // namespace ertbench
