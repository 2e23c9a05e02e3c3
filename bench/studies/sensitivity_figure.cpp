#include "bench/studies/sensitivity_figure.h"

#include <algorithm>
#include <cmath>

#include "bench/charts/method_styles.h"
#include "bench/plot/drawing.h"
#include "bench/plot/legend.h"
#include "bench/plot/panel.h"
#include "bench/studies/sheet_regions.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Panels of one size in rows of at most four, px.
struct CurveLayout {
  static constexpr double width = 214;
  static constexpr double height = 170;
  static constexpr double left = 60;
  static constexpr double top = 58;
  static constexpr double gap_x = 46;
  static constexpr double gap_y = 64;
  static constexpr double foot = 44;
  int panels;

  int columns() const { return std::min(panels, 4); }
  int rows() const { return (panels + columns() - 1) / columns(); }
  double picture_width() const { return left + columns() * (width + gap_x) - 20; }
  double picture_height() const { return top + rows() * (height + gap_y) + foot; }
  Box box(int panel) const {
    return Box::sized(left + panel % columns() * (width + gap_x),
                      top + panel / columns() * (height + gap_y), width, height);
  }
};

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
        layout_{static_cast<int>(set.solvers.size()) + 1},
        canvas_(layout_.picture_width(), layout_.picture_height()) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    int panel = 0;
    for (const PressResponse& solver : set_.solvers) {
      draw_solver(solver, layout_.box(panel), panel % layout_.columns() == 0);
      ++panel;
    }
    draw_regions(layout_.box(panel));
    Legend legend(CurveLayout::left, layout_.picture_width() - 10);
    const int regions = 1 + *std::max_element(region_of_.begin(), region_of_.end());
    for (int r = 0; r < regions; ++r) {
      const auto region = static_cast<std::size_t>(r);
      legend.add({"region " + roman(r), region_line(region), region_mark(region)});
    }
    legend.draw(canvas_, layout_.picture_height() - 32);
    canvas_.text(
        "while the force is raised; each panel has its own scale; bars: 95 % interval of the mean",
        CurveLayout::left, layout_.picture_height() - 10, {.size = 9, .align = TextAlign::left});
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
    if (!solver.failure.empty()) {
      canvas_.text(one_line(solver.failure, 34), box.middle(), box.centre(),
                   {.size = 9, .colour = ink::alarm});
    }
    for (std::size_t r = 0; r < regions.size(); ++r) {
      Points points;
      std::vector<Whisker> whiskers;
      for (std::size_t f = 0; f < set_.forces_N.size(); ++f) {
        const auto& at = regions[r].rising[f];
        if (!at) continue;
        points.emplace_back(set_.forces_N[f], at->value / background_);
        whiskers.push_back(
            {set_.forces_N[f], at->ci95.low / background_, at->ci95.high / background_});
      }
      axes.line(points, region_line(r));
      axes.whiskers(whiskers, {hue(r), 1});
      axes.marks(points, region_mark(r));
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
  CurveLayout layout_;
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
    Points points;
    std::vector<Whisker> whiskers;
    for (std::size_t f = 0; f < errors.size(); ++f) {
      if (!errors[f]) continue;
      points.emplace_back(set.forces_N[f], errors[f]->value);
      whiskers.push_back({set.forces_N[f], errors[f]->ci95.low, errors[f]->ci95.high});
    }
    const LineStyle line = styles.line(s);
    const MarkStyle mark = styles.mark(s);
    axes.line(points, line);
    axes.whiskers(whiskers, {styles.colour(s), 1});
    axes.marks(points, mark);
    legend.add({set.solvers[s].label, line, mark});
  }
  axes.draw();
  legend.draw(canvas, 352);
  canvas.draw(stem);
}

}  // namespace

ReportFigure sensitivity_curves(const SensitivitySet& set, const std::vector<int>& region_of,
                                double background, const std::string& law, const std::string& title,
                                const std::filesystem::path& stem) {
  const bool drawn = draw_or_say(stem, [&] {
    SensitivityCurves(set, region_of, background)
        .draw(title + ": strength of the image, " + set.condition + ", " + law + " law", stem);
  });
  return {"Strength against force by region, " + set.name, stem.string() + ".svg",
          set.condition + ", " + law + " law", drawn};
}

ReportFigure force_errors(const SensitivitySet& set, const std::string& law,
                          const std::string& title, const std::filesystem::path& stem) {
  const bool drawn = draw_or_say(stem, [&] {
    draw_force_errors(set, title + ": error of the force, " + set.condition + ", " + law + " law",
                      stem);
  });
  return {"Error of the calibrated force, " + set.name, stem.string() + ".svg",
          "from the peak; " + set.condition + ", " + law + " law", drawn};
}

}  // namespace ertbench
