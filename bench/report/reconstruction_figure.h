#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// One solver's images of the figure's scenes.
struct FigureColumn {
  std::string label;
  Images changes;                             ///< [scenes, pixels] S/m; empty where it failed
  std::vector<std::optional<double>> errors;  ///< [scenes], printed under each image; may be empty
  std::string failure;  ///< written in place of the images: "failed", "timed out"; else empty
};

/// True images and reconstructions side by side.
struct ReconstructionFigure {
  Sensor sensor;
  Images conductivity;                  ///< the true images [scenes, pixels] S/m
  bool truth_is_known = true;           ///< else the truth's column says so
  std::vector<std::string> row_labels;  ///< [scenes]: "scene 12"
  std::vector<FigureColumn> columns;
};

/// Draws `stem`.svg and `stem`.png: a row for each scene, in the columns the truth and each solver;
/// of more than nine solvers in bands below each other, each with the truth. Colour is the change
/// of the conductivity over the background, one scale for all images; where solvers overshoot the
/// truth by more than half its range, the scale ends there and its outermost colours stand for all
/// beyond (marked at the colour bar). Dots are electrodes; the image's row 0 is at the bottom.
/// Pixels that are not finite stay grey. Throws InputError where gnuplot is missing or a file
/// cannot be written, std::invalid_argument where sizes do not fit together.
void draw_reconstruction_figure(const ReconstructionFigure& figure,
                                const std::filesystem::path& stem);

}  // namespace ertbench
