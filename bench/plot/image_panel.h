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

/// A strip of the palette with the ticks of `axis` on its right, and its title upright beyond them.
void draw_colour_bar(Canvas& canvas, const Box& box, const Axis& axis,
                     Palette palette = Palette::sequential);

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

/// Draws `stem`.svg and `stem`.png: images [n, pixels] of the change of the conductivity over the
/// background, side by side, each with a label below it. One scale for all, zero in its
/// middle; a bar of so many millimetres; dots are electrodes, row 0 is at the bottom. Pixels that
/// are not finite stay grey. Throws as draw_reconstruction_figure.
void draw_images_figure(const Sensor& sensor, const Images& changes,
                        const std::vector<std::string>& labels, const std::filesystem::path& stem);

}  // namespace ertbench
