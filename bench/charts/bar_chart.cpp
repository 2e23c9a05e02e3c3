#include "bench/charts/bar_chart.h"

#include <utility>

#include "bench/experiment/chart_keys.h"

namespace ertbench {
BarChart::BarChart(const ChartRequest& request)
    : BarChart(request.place, read_row_labels(request.object, request.experiment),
               read_metrics(request.object, {kPublishedMetrics.begin(), kPublishedMetrics.end()})) {
}

BarChart::BarChart(ChartPlace place, std::vector<std::string> labels, std::vector<Metric> metrics)
    : Chart(std::move(place)), labels_(std::move(labels)), metrics_(std::move(metrics)) {}

Bars BarChart::bars_of(std::span<const ResultRow> rows, const std::string& title) const {
  Bars bars;
  bars.title = title;
  bars.labels = labels_;
  const ResultRow* truth = find_row(rows, "truth");
  for (const std::string& label : labels_) {
    bars.statuses.push_back(chart_status(find_row(rows, label)));
  }
  for (const Metric metric : metrics_) {
    BarPanel panel;
    panel.title = axis_title(metric);
    panel.decimals = decimals_of(metric);
    panel.ideal = ideal_of(metric, truth ? truth->metrics[metric].mean : std::nullopt);
    if (panel.ideal) panel.ideal_name = ideal_text(metric, *panel.ideal);
    for (const std::string& label : labels_) {
      const ResultRow* row = find_row(rows, label);
      panel.values.push_back(row ? BarValue{row->metrics[metric].mean, row->metrics[metric].ci95}
                                 : BarValue{});
    }
    bars.panels.push_back(std::move(panel));
  }
  return bars;
}

void BarChart::draw(std::span<const ResultRow> rows, const std::string& title,
                    const std::filesystem::path& folder) const {
  draw_bars(bars_of(rows, title), folder / name());
}

std::string BarChart::caption() const {
  return "means with their 95 % intervals, test set " + dataset();
}

}  // namespace ertbench
