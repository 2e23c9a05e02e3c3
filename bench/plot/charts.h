#pragma once

#include <filesystem>
#include <span>

#include "bench/experiment/chart_spec.h"
#include "bench/plot/bar_chart.h"
#include "bench/plot/heat_map.h"
#include "bench/record/result_row.h"

namespace ertbench {

/// What the chart shows of the rows. A row that is missing leaves its place with "not run".
BarChart bar_chart_of(const ChartSpec& spec, std::span<const ResultRow> rows,
                      const std::string& title);

/// The best cell is the one with the least mean relative error of those that are ok.
HeatMap heat_map_of(const ChartSpec& spec, std::span<const ResultRow> rows,
                    const std::string& title);

/// Draws `folder`/`name`.svg and .png; of a chart of speed and accuracy also writes the tables that
/// belong to it, `name`.md.
void draw(const ChartSpec& spec, std::span<const ResultRow> rows, const std::string& title,
          const std::filesystem::path& folder);

}  // namespace ertbench
