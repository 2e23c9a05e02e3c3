#include "bench/plot/drawing.h"

#include <spdlog/spdlog.h>

#include "core/atomic_file.h"
#include "core/html.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// A picture of a few lines of text.
std::string picture_of(const std::string& text) {
  constexpr int line_px = 16;
  const std::vector<std::string> lines = wrapped(one_line(text, 600), 90);
  const auto height = std::to_string(line_px * (static_cast<int>(lines.size()) + 2));
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"640\" height=\"" + height +
                    "\" viewBox=\"0 0 640 " + height + "\">\n<rect width=\"640\" height=\"" +
                    height + "\" fill=\"white\" stroke=\"black\"/>\n";
  int y = line_px;
  for (const std::string& line : lines) {
    y += line_px;
    svg.append("<text x=\"16\" y=\"")
        .append(std::to_string(y - line_px / 4))
        .append("\" font-family=\"sans-serif\" font-size=\"12\">")
        .append(html_escaped(line))
        .append("</text>\n");
  }
  return svg + "</svg>\n";
}

}  // namespace

bool draw_or_say(const std::filesystem::path& stem, const std::function<void()>& draw) {
  try {
    draw();
    return true;
  } catch (const std::exception& error) {
    const std::string name = stem.filename().string();
    spdlog::warn("the figure \"{}\" could not be drawn: {}", name, one_line(error.what(), 600));
    std::error_code ignored;
    std::filesystem::remove(stem.string() + ".png", ignored);
    write_file_atomically(stem.string() + ".svg", picture_of("This figure could not be drawn: " +
                                                             std::string(error.what())));
    return false;
  }
}

}  // namespace ertbench
