#include "bench/charts/chart_types.h"

#include "bench/charts/bar_chart.h"
#include "bench/charts/heat_map_chart.h"
#include "bench/charts/speed_chart.h"
#include "bench/charts/training_budget_chart.h"

namespace ertbench {
namespace {

template <typename T>
ChartType chart() {
  return {T::type, [](const ChartRequest& request) { return std::make_shared<const T>(request); }};
}

}  // namespace

ChartTypes chart_types() {
  return {chart<BarChart>(), chart<HeatMapChart>(), chart<SpeedChart>(),
          chart<TrainingBudgetChart>()};
}

}  // namespace ertbench
