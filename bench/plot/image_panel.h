#pragma once

#include <string>

#include "bench/plot/canvas.h"
#include "bench/plot/colour_scale.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Images on a canvas, with one colour scale. Dots are electrodes; the image's row 0 is at the
/// bottom; what is not finite stays grey.
class ImagePanels {
 public:
  /// Begins the drawing; `canvas` must be in multiplot mode and outlive this.
  ImagePanels(Canvas& canvas, const Sensor& sensor, const ColourScale& scale);

  /// A square of `side` px with an image [pixels], or none where that is empty, and a text in its
  /// middle.
  void image(double left, double top, double side,
             const Eigen::Ref<const Eigen::RowVectorXd>& values, const std::string& inside);
  /// A strip of the palette with its ticks; the last to be drawn.
  void colour_bar(double left, double top, double height, const std::string& quantity);

  const FileContents& files() const { return files_; }  ///< for the canvas to be drawn with

 private:
  Canvas& canvas_;
  ColourScale scale_;
  int grid_;
  Eigen::Vector2d low_, high_;  ///< corners of the sheet's bounds
  FileContents files_;
};

}  // namespace ertbench
