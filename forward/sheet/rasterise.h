#pragma once

#include <Eigen/Core>

#include "forward/sheet/pixel_grid.h"
#include "forward/sheet/scene.h"

namespace ertbench {

/// How a pixel that a contact covers in part gets its conductivity.
enum class Rasterisation {
  area,    ///< by the covered fraction of its area
  centre,  ///< by what covers its centre
};

/// Conductivity ratios sigma / background [pixels] of a scene, 1 where nothing presses and off the
/// sheet.
///
/// With `area` a pixel's ratio is the mean over its area. The covered fraction is exact for every
/// shape; only in pixels where the borders of two or more contacts meet is it integrated over
/// `overlap_lines` lines across the pixel, exactly along each line.
///
/// Of a scene with patches the patches alone count, by the fraction of each pixel's area that they
/// cover, whatever the rule.
void rasterise(const Scene& scene, const PixelGrid& pixels, Rasterisation rule,
               Eigen::Ref<Eigen::VectorXd> ratio);

/// The fraction of a box's area that a contact covers, exact for every shape.
double covered_fraction(const Contact& contact, const Eigen::AlignedBox2d& box);

inline constexpr int overlap_lines = 64;

const char* name_of(Rasterisation rule);

}  // namespace ertbench
