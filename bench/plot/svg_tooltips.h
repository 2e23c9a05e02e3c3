#pragma once

#include <string>
#include <vector>

namespace ertbench {

/// An invisible rectangle of a chart, px from its top left corner, over which the pointer shows
/// `text`; may have several lines.
struct Tooltip {
  double left = 0;
  double top = 0;
  double width = 0;
  double height = 0;
  std::string text;
};

/// The SVG picture with the tooltips above all that is drawn, the last one uppermost: `<title>`
/// elements, which need no script. Throws std::invalid_argument where `svg` has no end.
/// A chart need not call this: it says Canvas::tooltip() and Canvas::draw().
std::string with_tooltips(const std::string& svg, const std::vector<Tooltip>& tooltips);

}  // namespace ertbench
