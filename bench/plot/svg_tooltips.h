#pragma once

#include <string>
#include <vector>

#include "bench/plot/box.h"

namespace ertbench {

/// An invisible rectangle of a chart, over which the pointer shows `text`; may have several lines.
struct Tooltip {
  Box box;
  std::string text;
};

/// The SVG picture with the tooltips above all that is drawn, the last one uppermost: `<title>`
/// elements, which need no script. Throws std::invalid_argument where `svg` has no end.
/// A chart need not call this: it says Canvas::tooltip() and Canvas::draw().
std::string with_tooltips(const std::string& svg, const std::vector<Tooltip>& tooltips);

}  // namespace ertbench
