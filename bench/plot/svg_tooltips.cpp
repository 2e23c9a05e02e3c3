#include "bench/plot/svg_tooltips.h"

#include <stdexcept>

#include "core/html.h"
#include "core/text_stream.h"

namespace ertbench {

std::string with_tooltips(const std::string& svg, const std::vector<Tooltip>& tooltips) {
  if (tooltips.empty()) return svg;
  const auto end = svg.rfind("</svg>");
  if (end == std::string::npos) throw std::invalid_argument("tooltips: the SVG has no end");
  TextStream out;
  out << svg.substr(0, end) << "<g class=\"tooltips\" fill=\"none\" pointer-events=\"all\">\n";
  for (const Tooltip& tooltip : tooltips) {
    const Box& box = tooltip.box;
    out << "<rect x=\"" << box.left << "\" y=\"" << box.top << "\" width=\"" << box.width()
        << "\" height=\"" << box.height() << "\"><title>" << html_escaped(tooltip.text)
        << "</title></rect>\n";
  }
  out << "</g>\n" << svg.substr(end);
  return out.str();
}

}  // namespace ertbench
