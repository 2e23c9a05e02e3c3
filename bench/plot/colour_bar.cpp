#include "bench/plot/colour_bar.h"

#include <algorithm>

#include "core/text_stream.h"

namespace ertbench {

void draw_colour_bar(Canvas& canvas, const Box& box, const Axis& axis, Palette palette) {
  constexpr int size = 10;
  constexpr int steps = 256;
  double widest = 0;
  for (const Tick& tick : axis.ticks) {
    const double y = box.up(axis.share(tick.value));
    canvas.line(box.right, y, box.right + 3, y, {});
    canvas.text(tick.text, box.right + 5, y, {.size = size, .align = TextAlign::left});
    widest = std::max(widest, text_width(tick.text, size));
  }
  if (!axis.title.empty()) {
    canvas.text(axis.title, box.right + 17 + widest, box.centre(), {.size = 11, .upright = true});
  }
  TextStream strip;
  for (int i = 0; i < steps; ++i) {
    const double value = axis.low + (axis.high - axis.low) * (i + 0.5) / steps;
    strip << value << ' ' << value << '\n';
  }
  canvas.area(box);
  canvas.plots() << palette_command(palette)
                 << "unset key\nunset tics\nunset colorbox\nset cbrange [" << axis.low << ":"
                 << axis.high << "]\nset xrange [0:1]\nset yrange [0:" << steps
                 << "]\nset border 15 linecolor '#404040'\nplot " << canvas.data(strip.str())
                 << " matrix using (0.25 + 0.5 * $1):($2 + 0.5):3 with image\nunset border\n";
}

}  // namespace ertbench
