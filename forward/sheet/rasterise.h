#pragma once

#include <Eigen/Core>

#include "forward/sheet/pixel_grid.h"
#include "forward/sheet/scene.h"

namespace ertbench {

/// Rule for the conductivity of a pixel that a contact covers in part.
enum class Rasterisation {
  area,    ///< mean over the pixel's area
  centre,  ///< conductivity at the pixel's centre
};

/// Writes the conductivity ratios sigma / background [pixels] of a scene, 1 outside contacts and
/// off the sheet.
///
/// With `area` a pixel's ratio is the mean over its area. It is exact for every shape, except in
/// pixels where borders of several contacts meet: there it is integrated over `overlap_lines` lines
/// across the pixel, exactly along each line.
///
/// In a scene with patches only these count, by the covered fraction of each pixel's area under
/// either rule.
void rasterise(const Scene& scene, const PixelGrid& pixels, Rasterisation rule,
               Eigen::Ref<Eigen::VectorXd> ratio);

/// Fraction of a box's area that a contact covers, exact for every shape.
double covered_fraction(const Contact& contact, const Eigen::AlignedBox2d& box);

inline constexpr int overlap_lines = 64;

const char* name_of(Rasterisation rule);

}  // namespace ertbench
