#include <algorithm>

#include "bench/studies/drawing.h"
#include "bench/studies/targets.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Two panels side by side, px.
constexpr double chart_width = 900;
constexpr double chart_left = 56;
constexpr double chart_right = 26;
constexpr double chart_legend_top = 40;
constexpr double chart_panel = 200;

Axis number_axis(const std::vector<int>& numbers) {
  Axis axis{0.5, 5.5};
  if (!numbers.empty()) {
    axis.low = numbers.front() - 0.5;
    axis.high = numbers.back() + 0.5;
  }
  for (const int number : numbers) axis.ticks.push_back({double(number), std::to_string(number)});
  axis.title = "true contacts";
  axis.grid = false;
  return axis;
}

/// An axis from zero to the highest whisker.
Axis value_axis(const std::vector<TargetSolver>& solvers, const std::string& key,
                const std::string& title) {
  Span span{0, key == "recall" ? 1.0 : 0.0};
  for (const TargetSolver& solver : solvers) {
    for (const auto& [number, count] : solver.counts) {
      if (const auto& estimate = count.metrics.at(key)) span.extend(estimate->ci95.high);
    }
  }
  if (span.high <= 0) span.high = 1;
  return Axis::even(span, title);
}

void draw_counts(Canvas& canvas, const Box& box, const TargetResults& results,
                 const MethodStyles& styles, const std::string& key) {
  const std::string title = key == "recall" ? "recall" : "false positives a frame";
  const Axis values = value_axis(results.solvers, key, title);
  Panel axes(canvas, box, number_axis(results.numbers), values);
  axes.title(key == "recall" ? "Share of the contacts that were detected"
                             : "Detected contacts that are none");
  for (std::size_t n = 1; n < results.numbers.size(); ++n) {
    // Between two numbers, whose marks stand side by side and mean no fractions.
    const double border = (results.numbers[n - 1] + results.numbers[n]) / 2.0;
    axes.line({{border, values.low}, {border, values.high}}, {rgb(0xd0d0d0), 0.8});
  }
  const auto solvers = static_cast<double>(results.solvers.size());
  const double step = std::min(0.1, 0.6 / solvers);
  for (std::size_t s = 0; s < results.solvers.size(); ++s) {
    const TargetSolver& solver = results.solvers[s];
    // The marks of several solvers stand beside each other.
    const double beside = step * (static_cast<double>(s) - (solvers - 1) / 2);
    Series series;
    for (const auto& [number, count] : solver.counts) {
      const auto& estimate = count.metrics.at(key);
      if (!estimate) continue;
      const double x = number + beside;
      series.add(x, *estimate);
      const Cell cell = estimate_cell(estimate, 3);
      axes.tooltip(x, estimate->value,
                   solver.label + ", contacts: " + std::to_string(number) + "\n" + title + " " +
                       cell.text + " " + cell.interval);
    }
    series.draw(axes, styles.line(s), styles.mark(s), {styles.colour(s), 1});
  }
  axes.draw();
}

void draw_targets(const TargetResults& results, const std::string& heading,
                  const std::filesystem::path& stem) {
  const MethodStyles styles = styles_of(results.solvers);
  Legend legend(chart_left, chart_width - chart_right);
  for (std::size_t s = 0; s < results.solvers.size(); ++s) {
    const TargetSolver& solver = results.solvers[s];
    const std::string failure =
        solver.failure.empty() ? "" : " (" + one_line(solver.failure, 40) + ")";
    legend.add({solver.label + failure, styles.line(s), styles.mark(s)});
  }
  const double top = chart_legend_top + legend.height() + 22;
  Canvas canvas(chart_width, top + chart_panel + 64);
  canvas.title(heading);
  legend.draw(canvas, chart_legend_top);
  const double half = (chart_width - 2 * chart_left - 2 * chart_right) / 2;
  draw_counts(canvas, Box::sized(chart_left, top, half, chart_panel), results, styles, "recall");
  draw_counts(canvas, Box::sized(2 * chart_left + chart_right + half, top, half, chart_panel),
              results, styles, "ghosts");
  add_footnote(canvas, "marks: means; whiskers: their 95 % intervals", chart_left);
  canvas.draw(stem);
}

}  // namespace

StudyFigure targets_chart(const TargetCircumstances& circumstances,
                          std::shared_ptr<const TargetResults> results) {
  return {
      "", "Contacts detected",
      "recall and false positives by the number of contacts; " + circumstances.conditions,
      ": contacts detected, false positives; " + circumstances.conditions,
      [results](const auto& heading, const auto& stem) { draw_targets(*results, heading, stem); }};
}

}  // namespace ertbench
