#include <algorithm>
#include <cmath>

#include "bench/studies/drawing.h"
#include "bench/studies/sensitivity.h"

namespace ertbench {
namespace {

MarkStyle region_mark(std::size_t region) { return {filled(region), hue(region), 0.6, 1.2}; }
LineStyle region_line(std::size_t region) {
  return {hue(region), 1.3, 1 + static_cast<int>(region % 3)};
}

class SensitivityCurves {
 public:
  SensitivityCurves(const SensitivitySet& set, const std::vector<int>& region_of, double background)
      : set_(set),
        region_of_(region_of),
        background_(background),
        grid_{.panels = static_cast<int>(set.solvers.size()) + 1,
              .left = 60,
              .top = 58,
              .width = 214,
              .height = 170,
              .gap_x = 46,
              .gap_y = 64},
        canvas_(grid_.right() - 20, grid_.bottom() + 44) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    int panel = 0;
    for (const PressResponse& solver : set_.solvers) {
      draw_solver(solver, grid_.box(panel), panel % grid_.columns() == 0);
      ++panel;
    }
    draw_regions(grid_.box(panel));
    Legend legend(grid_.left, canvas_.width() - 10);
    const int regions = 1 + *std::max_element(region_of_.begin(), region_of_.end());
    for (int r = 0; r < regions; ++r) {
      const auto region = static_cast<std::size_t>(r);
      legend.add({"region " + roman(r), region_line(region), region_mark(region)});
    }
    legend.draw(canvas_, canvas_.height() - 32);
    add_footnote(
        canvas_,
        "while the force is raised; each panel has its own scale; bars: 95 % interval of the mean",
        grid_.left);
    canvas_.draw(stem);
  }

 private:
  void draw_solver(const PressResponse& solver, const Box& box, bool first_of_row) {
    const auto& regions = solver.readings[0].regions;
    Span span{0, 0};
    for (const PressResponse::Curve& curve : regions) {
      for (const auto& at : curve.rising) {
        if (at) span.extend(at->ci95.high / background_);
      }
    }
    span.high = span.high > 0 ? 1.08 * span.high : 1;
    Panel axes(canvas_, box, Axis::even({0, 1.05 * set_.forces_N.back()}, "force, N"),
               Axis::even(span, first_of_row ? "largest |δσ| / c₀" : ""));
    axes.title(solver.label);
    add_failure(canvas_, box, solver.failure);
    for (std::size_t r = 0; r < regions.size(); ++r) {
      Series series;
      for (std::size_t f = 0; f < set_.forces_N.size(); ++f) {
        const auto& at = regions[r].rising[f];
        if (!at) continue;
        series.add(set_.forces_N[f], {at->value / background_,
                                      {at->ci95.low / background_, at->ci95.high / background_}});
      }
      series.draw(axes, region_line(r), region_mark(r), {hue(r), 1});
    }
    axes.draw();
  }

  /// The areas in the colours of their regions, numbered from the top left as in the paper.
  void draw_regions(const Box& box) {
    const int areas = static_cast<int>(std::lround(std::sqrt(region_of_.size())));
    const double cell = std::min(box.width(), box.height()) / areas;
    canvas_.text("regions of the sheet", box.left + cell * areas / 2, box.top - 12, {.size = 11});
    for (int row = 0; row < areas; ++row) {
      for (int column = 0; column < areas; ++column) {
        const int region = region_of_[static_cast<std::size_t>(column + areas * row)];
        const Box area =
            Box::sized(box.left + column * cell, box.top + (areas - 1 - row) * cell, cell, cell);
        canvas_.rectangle(area, {.fill = hue(static_cast<std::size_t>(region)).towards_white(0.55),
                                 .border = LineStyle{ink::dark, 0.8}});
        canvas_.text(roman(region), area.middle(), area.centre(), {.size = 10});
      }
    }
  }

  const SensitivitySet& set_;
  const std::vector<int>& region_of_;
  double background_;
  PanelGrid grid_;
  Canvas canvas_;
};

void draw_force_errors(const SensitivitySet& set, const std::string& heading,
                       const std::filesystem::path& stem) {
  Canvas canvas(760, 400);
  canvas.title(heading);
  Span span{0, 0};
  for (const PressResponse& solver : set.solvers) {
    for (const auto& at : solver.readings[0].force_error_at) {
      if (at) span.extend(at->ci95.high);
    }
  }
  span.high = span.high > 0 ? 1.05 * span.high : 1;
  const Box box = Box::sized(64, 40, 670, 260);
  Panel axes(canvas, box, Axis::even({0, 1.05 * set.forces_N.back()}, "force, N"),
             Axis::even(span, "mean |error| of the force, N"));
  Legend legend(64, 740);
  const MethodStyles styles = styles_of(set.solvers);
  for (std::size_t s = 0; s < set.solvers.size(); ++s) {
    const auto& errors = set.solvers[s].readings[0].force_error_at;
    Series series;
    for (std::size_t f = 0; f < errors.size(); ++f) {
      if (errors[f]) series.add(set.forces_N[f], *errors[f]);
    }
    series.draw(axes, styles.line(s), styles.mark(s), {styles.colour(s), 1});
    legend.add({set.solvers[s].label, styles.line(s), styles.mark(s)});
  }
  axes.draw();
  legend.draw(canvas, 352);
  canvas.draw(stem);
}

}  // namespace

StudyFigure sensitivity_curves(std::shared_ptr<const SensitivitySet> set,
                               const std::vector<int>& region_of, double background,
                               const std::string& law) {
  const std::string condition = set->condition + ", " + law + " law";
  return {"_" + set->name, "Strength against force by region, " + set->name, condition,
          ": strength of the image, " + condition,
          [set, region_of, background](const auto& heading, const auto& stem) {
            SensitivityCurves(*set, region_of, background).draw(heading, stem);
          }};
}

StudyFigure force_errors(std::shared_ptr<const SensitivitySet> set, const std::string& law) {
  const std::string condition = set->condition + ", " + law + " law";
  return {"_force_" + set->name, "Error of the calibrated force, " + set->name,
          "from the peak; " + condition, ": error of the force, " + condition,
          [set](const auto& heading, const auto& stem) { draw_force_errors(*set, heading, stem); }};
}

}  // namespace ertbench
