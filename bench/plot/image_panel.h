#pragma once

#include <string>

#include "bench/plot/canvas.h"
#include "bench/plot/colour_scale.h"
#include "bench/plot/palette.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Images on a canvas, with one colour scale: diverging where it has zero in its middle, as changes
/// of the conductivity have. Dots are electrodes; the image's row 0 is at the
/// bottom; what is not finite stays grey.
class ImagePanels {
 public:
  static constexpr double bar_width = 11;  ///< of a colour bar without its ticks, px

  /// `canvas` must outlive this.
  ImagePanels(Canvas& canvas, const Sensor& sensor, const ColourScale& scale);

  /// An image [pixels], or none where that is empty, in a square box (of a sheet that is no
  /// square, in its proportions), and a text in its middle.
  void image(const Box& box, const Eigen::Ref<const Eigen::RowVectorXd>& values,
             const std::string& inside);
  /// A line of a round number of millimetres below a square box of an image, with its length.
  void scale_bar(const Box& box);
  /// A strip of the palette with its ticks.
  void colour_bar(const Box& box, const std::string& quantity);

 private:
  Canvas& canvas_;
  ColourScale scale_;
  Palette palette_;
  PixelGrid pixels_;
  double unit_mm_;              ///< length of a domain unit
  Eigen::Vector2d low_, high_;  ///< corners of the sheet's bounds
  std::string outline_;         ///< the sheet as an object of gnuplot
  std::string electrodes_;      ///< name of their file
};

}  // namespace ertbench
