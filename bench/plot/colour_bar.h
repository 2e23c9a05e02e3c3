#pragma once

#include "bench/plot/axis.h"
#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"

namespace ertbench {

/// A strip of the palette with the ticks of `axis` on its right, and its title upright beyond them.
void draw_colour_bar(Canvas& canvas, const Box& box, const Axis& axis,
                     Palette palette = Palette::sequential);

}  // namespace ertbench
