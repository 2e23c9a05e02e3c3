#include <algorithm>

#include "bench/studies/drawing.h"
#include "bench/studies/targets.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Two panels side by side, px.
class TargetsChart {
 public:
  explicit TargetsChart(const TargetResults& results)
      : results_(results),
        styles_(styles_of(results.solvers)),
        legend_(legend()),
        canvas_(width, height()) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    legend_.draw(canvas_, legend_top);
    const double half = (width - 2 * left - 2 * right) / 2;
    draw_counts("recall", Box::sized(left, top(), half, panel));
    draw_counts("ghosts", Box::sized(2 * left + right + half, top(), half, panel));
    add_footnote(canvas_, "marks: means; whiskers: their 95 % intervals", left);
    canvas_.draw(stem);
  }

 private:
  static constexpr double width = 900;
  static constexpr double left = 56;
  static constexpr double right = 26;
  static constexpr double legend_top = 40;
  static constexpr double panel = 200;

  Legend legend() const {
    Legend legend(left, width - right);
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const TargetSolver& solver = results_.solvers[s];
      const std::string failure =
          solver.failure.empty() ? "" : " (" + one_line(solver.failure, 40) + ")";
      legend.add({solver.label + failure, styles_.line(s), styles_.mark(s)});
    }
    return legend;
  }
  double top() const { return legend_top + legend_.height() + 22; }
  double height() const { return top() + panel + 64; }

  /// Offset of a solver's marks, so that those of several solvers stand beside each other.
  double beside(std::size_t solver, double step) const {
    const auto solvers = static_cast<double>(results_.solvers.size());
    return step * (static_cast<double>(solver) - (solvers - 1) / 2);
  }

  Axis number_axis() const {
    Axis axis{0.5, 5.5};
    if (!results_.numbers.empty()) {
      axis.low = results_.numbers.front() - 0.5;
      axis.high = results_.numbers.back() + 0.5;
    }
    for (const int number : results_.numbers) {
      axis.ticks.push_back({double(number), std::to_string(number)});
    }
    axis.title = "true contacts";
    axis.grid = false;
    return axis;
  }

  /// An axis from zero to the highest whisker.
  Axis value_axis(const std::string& key, const std::string& title) const {
    Span span{0, key == "recall" ? 1.0 : 0.0};
    for (const TargetSolver& solver : results_.solvers) {
      for (const auto& [number, count] : solver.counts) {
        if (const auto& estimate = count.metrics.at(key)) span.extend(estimate->ci95.high);
      }
    }
    if (span.high <= 0) span.high = 1;
    return Axis::even(span, title);
  }

  void draw_counts(const std::string& key, const Box& box) {
    const std::string title = key == "recall" ? "recall" : "false positives a frame";
    const Axis values = value_axis(key, title);
    Panel axes(canvas_, box, number_axis(), values);
    axes.title(key == "recall" ? "Share of the contacts that were detected"
                               : "Detected contacts that are none");
    const double step = std::min(0.1, 0.6 / static_cast<double>(results_.solvers.size()));
    for (std::size_t n = 1; n < results_.numbers.size(); ++n) {
      // Between two numbers, whose marks stand side by side and mean no fractions.
      const double border = (results_.numbers[n - 1] + results_.numbers[n]) / 2.0;
      axes.line({{border, values.low}, {border, values.high}}, {rgb(0xd0d0d0), 0.8});
    }
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const TargetSolver& solver = results_.solvers[s];
      Series series;
      for (const auto& [number, count] : solver.counts) {
        const auto& estimate = count.metrics.at(key);
        if (!estimate) continue;
        const double x = number + beside(s, step);
        series.add(x, *estimate);
        const Cell cell = estimate_cell(estimate, 3);
        axes.tooltip(x, estimate->value,
                     solver.label + ", contacts: " + std::to_string(number) + "\n" + title + " " +
                         cell.text + " " + cell.interval);
      }
      series.draw(axes, styles_.line(s), styles_.mark(s), {styles_.colour(s), 1});
    }
    axes.draw();
  }

  const TargetResults& results_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
};

}  // namespace

StudyFigure targets_chart(const TargetCircumstances& circumstances,
                          std::shared_ptr<const TargetResults> results) {
  return {"", "Contacts detected",
          "recall and false positives by the number of contacts; " + circumstances.conditions,
          ": contacts detected, false positives; " + circumstances.conditions,
          [results](const auto& heading, const auto& stem) {
            TargetsChart(*results).draw(heading, stem);
          }};
}

}  // namespace ertbench
