#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/plot/canvas.h"
#include "bench/plot/palette.h"
#include "bench/plot/panel.h"
#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Draws a strip of the palette with the ticks of `axis` on its right and a vertical title.
void draw_colour_bar(Canvas& canvas, const Box& box, const Axis& axis,
                     Palette palette = Palette::sequential);

/// Images on a canvas with one colour scale, diverging if zero is in its middle, as for changes of
/// the conductivity. Dots are electrodes; row 0 is at the bottom; pixels that are not finite are
/// grey.
class ImagePanels {
 public:
  static constexpr double bar_width = 11;  ///< of a colour bar without its ticks, px

  /// `canvas` must outlive this.
  ImagePanels(Canvas& canvas, const Sensor& sensor, const ColourScale& scale);

  /// An image [pixels], or none if it is empty, in a square box (with the proportions of the
  /// sheet), and a text in its centre.
  void image(const Box& box, const Eigen::Ref<const Eigen::RowVectorXd>& values,
             const std::string& inside);
  /// A scale bar of a round number of millimetres below the box of an image.
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

/// Draws `stem`.svg and `stem`.png: images [n, pixels] of the change of the conductivity over the
/// background, side by side, each with a label below it, as ImagePanel does, with one colour scale
/// around zero and a scale bar. Throws like draw_reconstruction_figure.
void draw_images_figure(const Sensor& sensor, const Images& changes,
                        const std::vector<std::string>& labels, const std::filesystem::path& stem);

}  // namespace ertbench
