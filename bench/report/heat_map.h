#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ertbench {

/// One quantity over the grid; less colour value is better.
struct HeatMapPanel {
  std::string title;                           ///< "AR"
  std::string quantity;                        ///< that the colours stand for: "|AR − 1|"
  int decimals = 3;                            ///< of the values written into the cells
  std::vector<std::optional<double>> values;   ///< [y * columns + x], written
  std::vector<std::optional<double>> colours;  ///< [y * columns + x]
  std::vector<std::string> texts = {};         ///< written in place of the values; may be empty
  /// Ends of the colour scale; by default from the best to the worst.
  std::optional<std::pair<double, double>> range = {};
};

/// Places on the grid.
struct HeatMapCell {
  int x = 0;
  int y = 0;
};

/// Results of a sweep over two parameters, a cell for each combination.
struct HeatMap {
  std::string title;
  std::string x_name;  ///< of what the columns are; may be empty, where the values say it
  std::string y_name;
  std::vector<std::string> x_values;  ///< from the left
  std::vector<std::string> y_values;  ///< from below
  std::vector<std::string> statuses;  ///< [y * columns + x]; empty where all is well
  std::vector<HeatMapPanel> panels;
  std::optional<HeatMapCell> published;
  std::optional<HeatMapCell> best;
  std::string published_note;  ///< below the panels, behind the published mark
  std::string best_note;
};

/// Draws `stem`.svg and `stem`.png, two panels a row. Where a few values lie far above the others,
/// the colours end before them (≥ at the colour bar). Cells whose status is not empty are grey and
/// crossed out. Throws InputError where gnuplot is missing or a file cannot be written,
/// std::invalid_argument where sizes do not fit together.
void draw_heat_map(const HeatMap& map, const std::filesystem::path& stem);

}  // namespace ertbench
