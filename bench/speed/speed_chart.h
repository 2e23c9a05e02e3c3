#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"

namespace ertbench {

/// Recommendations (within 1, 5 and 20 % of the least error, and for each budget), the right sizes,
/// and every configuration with its numbers; the text says how to read them.
Table speed_table(const SpeedAccuracy& chart, const std::string& title);

/// The recommendations for programs and pages, one row each: choice, margin or budget_us, label,
/// the mean error on the test set with its interval, p50_us and p99_us.
TableSection speed_choices(const SpeedAccuracy& chart);

/// Error against time: `{"type": "speed-accuracy", "name", "solvers", "metric", "dataset",
/// "budgets_us", "break_even_against": [labels]}`. Its tables are also written to `name`.md, its
/// recommendations to `name`_choices.csv and to summary.json under "speed_accuracy".
class SpeedChart : public Chart {
 public:
  static constexpr const char* type = "speed-accuracy";

  explicit SpeedChart(const ChartRequest& request);

  const SpeedQuestion& question() const { return question_; }

  void draw(std::span<const ResultRow> rows, const std::string& title,
            const std::filesystem::path& folder) const override;
  std::string caption() const override;
  std::string section() const override { return "Speed and accuracy: " + dataset(); }
  Table table(std::span<const ResultRow> rows) const override;
  void summarise(std::span<const ResultRow> rows, nlohmann::json& summary) const override;

 private:
  SpeedQuestion question_;
};

/// One of the two panels of the chart, which share the scale of errors.
struct SpeedPanel {
  Box box;
  Axis axis;    ///< horizontal: times or rates
  Axis errors;  ///< vertical
  std::string title;
  std::vector<std::optional<double>> x;  ///< [points] µs or frames per second
  bool SpeedPoint::*frontier;
  bool batches;  ///< the horizontal axis shows frames per second, with better values on the right

  bool shows(const SpeedAccuracy& chart, std::size_t point) const {
    return x[point] && chart.points[point].error;
  }
  /// True if the error lies on the scale and not above it.
  bool holds(double error) const { return error <= errors.high; }
  double x_of(double value) const { return box.across(axis.share(value)); }               ///< px
  double y_of(double error) const { return box.up(errors.share(errors.capped(error))); }  ///< px
};

SpeedPanel speed_panel(const SpeedAccuracy& chart, const Box& box, bool batches);

/// The corners of the frontier, from the upper edge to the far side, in the panel's units.
Points staircase(const SpeedAccuracy& chart, const SpeedPanel& panel);

/// The labels by descending priority: the frontier and the right sizes, each family that has no
/// name yet, then points that failed or lie beyond the scale (one name for three or more of a
/// family). `colour_of` gives the colour of a point's name.
std::vector<PointLabel> labels_of(const SpeedAccuracy& chart, const SpeedPanel& panel,
                                  const std::function<Colour(const SpeedPoint&)>& colour_of);

/// Draws `stem`.svg and `stem`.png: on the left the mean error against the time of one frame (p50
/// with a whisker to p99, 95 % interval of the mean), on the right against the frames per second
/// in batches. A line joins each family, a staircase the configurations that no faster one beats. A
/// configuration that failed or did not converge is hollow or, without numbers, named in a corner.
/// Throws InputError if gnuplot is missing or a file cannot be written.
void draw_speed_figure(const SpeedAccuracy& chart, const std::string& title,
                       const std::filesystem::path& stem);

/// Draws the front page's chart, `stem`.svg and `stem`.png: the mean error of seven methods against
/// the time of one frame, their frontier, and the interval of the best known estimator.
void draw_frontier_figure(const SpeedAccuracy& chart, std::span<const ResultRow> rows,
                          const std::filesystem::path& stem);

}  // namespace ertbench
