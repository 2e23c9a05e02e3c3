#include "bench/plot/charts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/analysis/chart_text.h"
#include "bench/analysis/speed_tables.h"
#include "bench/plot/speed_chart.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

const ResultRow* find_row(const ChartSpec& spec, std::span<const ResultRow> rows,
                          const std::string& label) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const ResultRow& row) {
    return row.label == label && row.dataset == spec.dataset;
  });
  return found == rows.end() ? nullptr : &*found;
}

std::string status_of(const ResultRow* row) {
  if (!row) return "not run";
  return row->ok() ? "" : row->status;
}

/// The values of a sweep's two parameters, in the order of the numbers or as the file has them.
struct Axis {
  std::string name;
  std::vector<json> values;

  void add(const json& value) {
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
  }
  void sort() {
    const bool numbers = std::all_of(values.begin(), values.end(),
                                     [](const json& value) { return value.is_number(); });
    if (numbers) std::sort(values.begin(), values.end());
  }
  std::optional<int> find(const json& value) const {
    const auto found = std::find(values.begin(), values.end(), value);
    if (found == values.end()) return std::nullopt;
    return static_cast<int>(found - values.begin());
  }
  std::vector<std::string> texts() const;
};

std::string text_of(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number()) return value.dump();
  char text[32];
  std::snprintf(text, sizeof text, "%g", value.get<double>());
  return text;
}

std::vector<std::string> Axis::texts() const {
  std::vector<std::string> out;
  for (const json& value : values) out.push_back(text_of(value));
  return out;
}

/// What the colours of a metric stand for: the smaller, the better.
std::optional<double> colour_value(const ResultRow& row, Metric metric) {
  if (const Metric distance = entry_of(metric).distance; distance != metric) {
    return row.metrics[distance].mean;
  }
  const auto& mean = row.metrics[metric].mean;
  if (!mean) return std::nullopt;
  return distance_from_ideal(metric, *mean, std::nullopt);
}

std::string pair_text(const Axis& x, const json& x_value, const Axis& y, const json& y_value) {
  return x.name + " = " + text_of(x_value) + ", " + y.name + " = " + text_of(y_value);
}

/// The rows on the grid of the two parameters.
struct Grid {
  Axis x;
  Axis y;
  std::vector<const ResultRow*> cells;  ///< [y * columns + x]; null where there is none
};

Grid grid_of(const ChartSpec& spec, std::span<const ResultRow> rows) {
  Grid grid;
  std::vector<std::pair<json, const ResultRow*>> points;
  for (const std::string& label : spec.labels) {
    const ResultRow* row = find_row(spec, rows, label);
    if (!row || row->sweep_json.empty()) continue;
    const json values = json::parse(row->sweep_json);
    if (values.size() != 2) continue;
    grid.x.name = values.begin().key();
    grid.y.name = std::next(values.begin()).key();
    grid.x.add(values.at(grid.x.name));
    grid.y.add(values.at(grid.y.name));
    points.emplace_back(values, row);
  }
  grid.x.sort();
  grid.y.sort();
  grid.cells.resize(grid.x.values.size() * grid.y.values.size());
  for (const auto& [values, row] : points) {
    const int x = *grid.x.find(values.at(grid.x.name));
    const int y = *grid.y.find(values.at(grid.y.name));
    grid.cells[static_cast<std::size_t>(y) * grid.x.values.size() + static_cast<std::size_t>(x)] =
        row;
  }
  return grid;
}

void mark_published(const ChartSpec& spec, const Grid& grid, HeatMap& map) {
  if (!spec.published_optimum) return;
  const json x = json::parse(spec.published_optimum->first);
  const json y = json::parse(spec.published_optimum->second);
  const auto column = grid.x.find(x);
  const auto row = grid.y.find(y);
  map.published_note = "paper's choice: " + pair_text(grid.x, x, grid.y, y);
  if (column && row) {
    map.published = HeatMapCell{*column, *row};
  } else {
    map.published_note += ", not on this grid";
  }
}

void mark_best(const Grid& grid, HeatMap& map) {
  double least = 0;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    if (!grid.cells[i] || !grid.cells[i]->ok()) continue;
    const auto& error = grid.cells[i]->metrics[Metric::relative_error].mean;
    if (!error || (map.best && *error >= least)) continue;
    least = *error;
    const std::size_t columns = grid.x.values.size();
    map.best = HeatMapCell{static_cast<int>(i % columns), static_cast<int>(i / columns)};
  }
  if (!map.best) return;
  map.best_note = "best here: " +
                  pair_text(grid.x, grid.x.values[static_cast<std::size_t>(map.best->x)], grid.y,
                            grid.y.values[static_cast<std::size_t>(map.best->y)]) +
                  " (least mean relative error, " + three_digits(least) + ")";
}

}  // namespace

BarChart bar_chart_of(const ChartSpec& spec, std::span<const ResultRow> rows,
                      const std::string& title) {
  BarChart chart;
  chart.title = title;
  chart.labels = spec.labels;
  const ResultRow* truth = find_row(spec, rows, "truth");
  for (const std::string& label : spec.labels) {
    chart.statuses.push_back(status_of(find_row(spec, rows, label)));
  }
  for (const Metric metric : spec.metrics) {
    BarPanel panel;
    panel.title = axis_title(metric);
    panel.decimals = decimals_of(metric);
    panel.ideal = ideal_of(metric, truth ? truth->metrics[metric].mean : std::nullopt);
    if (panel.ideal) panel.ideal_name = ideal_text(metric, *panel.ideal);
    for (const std::string& label : spec.labels) {
      const ResultRow* row = find_row(spec, rows, label);
      panel.values.push_back(row ? BarValue{row->metrics[metric].mean, row->metrics[metric].ci95}
                                 : BarValue{});
    }
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

HeatMap heat_map_of(const ChartSpec& spec, std::span<const ResultRow> rows,
                    const std::string& title) {
  const Grid grid = grid_of(spec, rows);
  HeatMap map;
  map.title = title;
  map.x_name = grid.x.name;
  map.y_name = grid.y.name;
  map.x_values = grid.x.texts();
  map.y_values = grid.y.texts();
  for (const ResultRow* row : grid.cells) map.statuses.push_back(status_of(row));
  for (const Metric metric : spec.metrics) {
    HeatMapPanel panel{axis_title(metric), distance_title(metric), decimals_of(metric), {}, {}};
    for (const ResultRow* row : grid.cells) {
      panel.values.push_back(row ? row->metrics[metric].mean : std::nullopt);
      panel.colours.push_back(row ? colour_value(*row, metric) : std::nullopt);
    }
    map.panels.push_back(std::move(panel));
  }
  mark_published(spec, grid, map);
  mark_best(grid, map);
  return map;
}

void draw(const ChartSpec& spec, std::span<const ResultRow> rows, const std::string& title,
          const std::filesystem::path& folder) {
  const std::filesystem::path stem = folder / spec.name;
  if (spec.type == ChartSpec::Type::bars) {
    draw_bar_chart(bar_chart_of(spec, rows, title), stem);
  } else if (spec.type == ChartSpec::Type::speed_accuracy) {
    const SpeedAccuracy chart = speed_accuracy_of(spec, rows);
    draw_speed_chart(chart, title, stem);
    write_file_atomically(stem.string() + ".md", markdown_of(speed_table(chart, title)));
  } else {
    draw_heat_map(heat_map_of(spec, rows, title), stem);
  }
}

}  // namespace ertbench
