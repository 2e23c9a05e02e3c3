#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/studies/drawing.h"
#include "bench/studies/localisation.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

Points circle_around(const Vector2d& centre, double radius) {
  Points out;
  constexpr int corners = 20;
  for (int i = 0; i <= corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    out.emplace_back(centre.x() + radius * std::cos(angle), centre.y() + radius * std::sin(angle));
  }
  return out;
}

const PlaceErrors::Rule& thresholded(const PlaceErrors& solver) {
  return solver.rules[static_cast<std::size_t>(PlaceRule::thresholded)];
}

class LocalisationMap {
 public:
  LocalisationMap(const LocalisedSet& set, double side_mm)
      : set_(set),
        grid_{.panels = static_cast<int>(set.solvers.size()) + (set.bound_mm.empty() ? 0 : 1)},
        canvas_(grid_.right(), grid_.bottom() + 34),
        span_{-side_mm / 2, side_mm / 2} {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    int panel = 0;
    for (const PlaceErrors& solver : set_.solvers) draw_solver(solver, grid_.box(panel++));
    if (!set_.bound_mm.empty()) draw_bound(grid_.box(panel));
    Legend legend(grid_.left, grid_.right() - 10);
    legend.add({"target", {}, target});
    legend.add(
        {"mean estimated position, a line from its target", LineStyle{found.colour, 1.2}, found});
    legend.add(
        {"rms distance of single frames around it", {}, MarkStyle{6, scatter.colour, 1.2, 1}});
    if (!set_.bound_mm.empty()) {
      legend.add({"Cramér–Rao bound of the rms", {}, MarkStyle{6, bound.colour, 1.2, 1.4}});
    }
    legend.draw(canvas_, canvas_.height() - 30);
    canvas_.draw(stem);
  }

 private:
  static constexpr MarkStyle target{7, ink::black, 0.35, 1};
  inline static const MarkStyle found{cross, hue(1), 0.55, 1.5};
  inline static const LineStyle scatter{ink::light, 0.8};
  inline static const LineStyle bound{hue(2), 1.4};

  Panel panel(const Box& box, const std::string& title) {
    Panel out(canvas_, box, Axis::even(span_), Axis::even(span_));
    out.title(title);
    return out;
  }

  void draw_solver(const PlaceErrors& solver, const Box& box) {
    const auto& median = thresholded(solver).median;
    Panel axes = panel(box, solver.label + (median ? ", median " + fixed(median->value, 1) + " mm"
                                                   : std::string()));
    add_failure(canvas_, box, solver.failure);
    std::vector<Vector2d> means;
    for (std::size_t p = 0; p < solver.found.size(); ++p) {
      if (!solver.found[p]) continue;
      axes.line(circle_around(*solver.found[p], solver.scatter_mm[p]), scatter);
    }
    for (std::size_t p = 0; p < solver.found.size(); ++p) {
      if (!solver.found[p]) continue;
      axes.line(points_of({set_.places[p], *solver.found[p]}), {found.colour, 1.2});
      means.push_back(*solver.found[p]);
    }
    axes.marks(points_of(means), found);
    axes.marks(points_of(set_.places), target);
    axes.draw();
  }

  void draw_bound(const Box& box) {
    Panel axes =
        panel(box, "Cramér–Rao, median " + fixed(median(SortedValues(set_.bound_mm)), 1) + " mm");
    for (std::size_t p = 0; p < set_.places.size(); ++p) {
      axes.line(circle_around(set_.places[p], std::min(set_.bound_mm[p], span_.high)), bound);
    }
    axes.marks(points_of(set_.places), target);
    axes.draw();
  }

  const LocalisedSet& set_;
  PanelGrid grid_;
  Canvas canvas_;
  Span span_;
};

/// Error by condition, a column a set.
class LocalisationOverview {
 public:
  LocalisationOverview(const std::vector<LocalisedSet>& sets, double slot)
      : sets_(sets),
        names_(set_names(sets), slot),
        width_(slot * static_cast<double>(sets.size())),
        canvas_(left + width_ + 20, top + height + names_.height() + 80) {}

  void draw(const std::string& heading, const std::filesystem::path& stem) {
    canvas_.title(heading);
    const Box box = Box::sized(left, top, width_, height);
    Panel axes(canvas_, box, {0, static_cast<double>(sets_.size())},
               Axis::logarithms(span(), "localisation error, mm"));
    Legend legend(left, left + width_);
    const std::size_t solvers = sets_.front().solvers.size();
    const MethodStyles styles = styles_of(sets_.front().solvers);
    for (std::size_t s = 0; s < solvers; ++s) {
      const MarkStyle mark = styles.mark(s);
      Points medians;
      std::vector<Whisker> whiskers;
      for (std::size_t i = 0; i < sets_.size(); ++i) {
        const PlaceErrors& solver = sets_[i].solvers[s];
        const auto& rule = thresholded(solver);
        if (!rule.median || !rule.p95) continue;
        const double x = static_cast<double>(i) + 0.14 +
                         0.72 * static_cast<double>(s) / std::max<double>(1, double(solvers) - 1);
        medians.emplace_back(x, rule.median->value);
        whiskers.push_back({x, rule.median->value, rule.p95->value});
        axes.tooltip(x, rule.median->value,
                     solver.label + "\n" + sets_[i].condition + "\nmedian " +
                         fixed(rule.median->value, 2) + " mm, 95 % " + fixed(rule.p95->value, 2) +
                         " mm");
      }
      axes.whiskers(whiskers, {styles.colour(s), 1.3});
      axes.marks(medians, mark);
      legend.add({sets_.front().solvers[s].label, {}, mark});
    }
    for (std::size_t i = 0; i < sets_.size(); ++i) {
      if (sets_[i].bound_mm.empty()) continue;
      const double bound = median(SortedValues(sets_[i].bound_mm));
      axes.line({{double(i) + 0.05, bound}, {double(i) + 0.95, bound}}, {ink::black, 1.6, 2});
    }
    legend.add(
        {"Cramér–Rao bound of the rms error, median of the places", LineStyle{ink::black, 1.6, 2}});
    axes.draw();
    names_.draw(canvas_, box.left, box.bottom);
    legend.draw(canvas_, box.bottom + names_.height() + 20);
    add_footnote(
        canvas_,
        "marks: median error of the thresholded centroid, of the frames that show a touch; bars "
        "up to the error that 95 % do not exceed. A median may be below the rms error's bound.",
        left);
    canvas_.draw(stem);
  }

 private:
  static constexpr double left = 64;
  static constexpr double top = 40;
  static constexpr double height = 300;

  static std::vector<std::string> set_names(const std::vector<LocalisedSet>& sets) {
    std::vector<std::string> out;
    for (const LocalisedSet& set : sets) out.push_back(set.name + ": " + set.condition);
    return out;
  }

  Span span() const {
    Span out;
    for (const LocalisedSet& set : sets_) {
      for (const PlaceErrors& solver : set.solvers) {
        const auto& rule = thresholded(solver);
        if (rule.median) out.extend(std::max(0.01, rule.median->value));
        if (rule.p95) out.extend(std::max(0.01, rule.p95->value));
      }
      if (!set.bound_mm.empty()) out.extend(median(SortedValues(set.bound_mm)));
    }
    return log_span(out, 1.3);
  }

  const std::vector<LocalisedSet>& sets_;
  CategoryNames names_;
  double width_;
  Canvas canvas_;
};

}  // namespace

StudyFigure localisation_map(std::shared_ptr<const LocalisedSet> set, double side_mm,
                             const std::string& law) {
  return {"_map_" + set->name, "Targets and estimated positions, " + set->name,
          "axes in mm from the sheet's centre; " + set->condition + ", " + law +
              " law; positions by the thresholded centroid",
          ": " + set->condition + ", " + law + " law; axes in mm",
          [set, side_mm](const auto& heading, const auto& stem) {
            LocalisationMap(*set, side_mm).draw(heading, stem);
          }};
}

StudyFigure localisation_overview(std::shared_ptr<const std::vector<LocalisedSet>> sets,
                                  const std::string& law) {
  return {"", "Localisation errors", "median and 95 % by solver and condition", ", " + law + " law",
          [sets](const auto& heading, const auto& stem) {
            const double slot = std::max(110.0, 760.0 / static_cast<double>(sets->size()));
            LocalisationOverview(*sets, slot).draw(heading, stem);
          }};
}

}  // namespace ertbench
