#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment_charts.h"
#include "bench/report/heat_map.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

std::string text_of(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.is_number() ? number_text(value.get<double>()) : json_text(value);
}

/// The values of one of a sweep's parameters.
struct Axis {
  std::string name;
  std::vector<json> values;

  std::optional<int> find(const json& value) const {
    const auto found = std::ranges::find(values, value);
    if (found == values.end()) return std::nullopt;
    return static_cast<int>(found - values.begin());
  }
  std::vector<std::string> texts() const {
    std::vector<std::string> out;
    for (const json& value : values) out.push_back(text_of(value));
    return out;
  }
};

/// The parameter's values in the order of the numbers, or as the file has them.
Axis axis_of(const std::vector<const ResultRow*>& points, int parameter) {
  Axis out;
  if (points.empty()) return out;
  out.name = std::next(points.front()->sweep->begin(), parameter).key();
  out.values = distinct(points, [&](const ResultRow* row) { return row->sweep->at(out.name); });
  if (std::ranges::all_of(out.values, &json::is_number)) std::ranges::sort(out.values);
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

/// `find` gives the row of a label.
template <typename Find>
Grid grid_of(const std::vector<std::string>& labels, const Find& find) {
  std::vector<const ResultRow*> points;
  for (const std::string& label : labels) {
    const ResultRow* row = find(label);
    if (row && row->sweep->size() == 2) points.push_back(row);
  }
  Grid grid{axis_of(points, 0), axis_of(points, 1), {}};
  grid.cells.resize(grid.x.values.size() * grid.y.values.size());
  for (const ResultRow* row : points) {
    const int x = *grid.x.find(row->sweep->at(grid.x.name));
    const int y = *grid.y.find(row->sweep->at(grid.y.name));
    grid.cells[static_cast<std::size_t>(y) * grid.x.values.size() + static_cast<std::size_t>(x)] =
        row;
  }
  return grid;
}

void mark_published(const HeatMapChart::Optimum& published, const Grid& grid, HeatMap& map) {
  const json& x = *published.first;
  const json& y = *published.second;
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

std::optional<HeatMapChart::Optimum> read_optimum(JsonObject& object) {
  if (!object.has("published_optimum")) return std::nullopt;
  const json& values = object.raw("published_optimum");
  if (!values.is_array() || values.size() != 2 || values[0].is_structured() ||
      values[1].is_structured()) {
    object.fail("published_optimum",
                "must be two values, of the swept parameters in alphabetical order");
  }
  return HeatMapChart::Optimum(values[0], values[1]);
}

}  // namespace

HeatMapChart::HeatMapChart(const ChartRequest& request)
    : HeatMapChart(request.place, read_sweep_labels(request.object, request.experiment),
                   read_metrics(request.object, {Metric::AR, Metric::PE}),
                   read_optimum(request.object)) {}

HeatMapChart::HeatMapChart(ChartPlace place, std::vector<std::string> labels,
                           std::vector<Metric> metrics, std::optional<Optimum> published)
    : Chart(std::move(place)),
      labels_(std::move(labels)),
      metrics_(std::move(metrics)),
      published_(std::move(published)) {}

HeatMap HeatMapChart::map_of(std::span<const ResultRow> rows, const std::string& title) const {
  const Grid grid =
      grid_of(labels_, [&](const std::string& label) { return find_row(rows, label); });
  HeatMap map;
  map.title = title;
  map.x_name = grid.x.name;
  map.y_name = grid.y.name;
  map.x_values = grid.x.texts();
  map.y_values = grid.y.texts();
  for (const ResultRow* row : grid.cells) map.statuses.push_back(chart_status(row));
  for (const Metric metric : metrics_) {
    HeatMapPanel panel{axis_title(metric), distance_title(metric), decimals_of(metric), {}, {}};
    for (const ResultRow* row : grid.cells) {
      panel.values.push_back(row ? row->metrics[metric].mean : std::nullopt);
      panel.colours.push_back(row ? colour_value(*row, metric) : std::nullopt);
    }
    map.panels.push_back(std::move(panel));
  }
  if (published_) mark_published(*published_, grid, map);
  mark_best(grid, map);
  return map;
}

void HeatMapChart::draw(std::span<const ResultRow> rows, const std::string& title,
                        const std::filesystem::path& folder) const {
  draw_heat_map(map_of(rows, title), folder / name());
}

std::string HeatMapChart::caption() const {
  return "means over the swept parameters, test set " + dataset();
}

}  // namespace ertbench
