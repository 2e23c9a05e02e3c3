#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/chart.h"
#include "bench/score/metrics.h"
#include "core/json.h"

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

/// A sweep of two parameters as a map: `{"type": "heat-map", "name", "solver": the label of the
/// sweep, "metrics", "dataset", "published_optimum": [first, second]}`.
class HeatMapChart : public Chart {
 public:
  static constexpr const char* type = "heat-map";

  /// The published values of both parameters, in their alphabetical order.
  using Optimum = std::pair<JsonValue, JsonValue>;

  explicit HeatMapChart(const ChartRequest& request);
  HeatMapChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics,
               std::optional<Optimum> published);

  /// The map that the chart makes of the rows. The best cell is the one with the least mean
  /// relative error of those that are ok.
  HeatMap map_of(std::span<const ResultRow> rows, const std::string& title) const;

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;

 private:
  std::vector<std::string> labels_;  ///< of the sweep's rows
  std::vector<Metric> metrics_;
  std::optional<Optimum> published_;
};

}  // namespace ertbench
