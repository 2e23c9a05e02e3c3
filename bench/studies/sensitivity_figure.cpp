#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/report/chart.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/sensitivity.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

std::size_t force_index(const std::vector<double>& forces, double force) {
  const auto found = std::min_element(forces.begin(), forces.end(), [&](double a, double b) {
    return std::abs(a - force) < std::abs(b - force);
  });
  return static_cast<std::size_t>(found - forces.begin());
}

/// Means of neighbours that fall are joined until none falls; a joined one counts as often as it
/// has members.
std::vector<double> made_monotone(const std::vector<double>& means) {
  struct Block {
    double mean;
    std::size_t count;
  };
  std::vector<Block> blocks;
  for (const double mean : means) {
    blocks.push_back({mean, 1});
    while (blocks.size() > 1 && blocks[blocks.size() - 2].mean >= blocks.back().mean) {
      const Block last = blocks.back();
      blocks.pop_back();
      Block& before = blocks.back();
      const std::size_t count = before.count + last.count;
      before.mean = (before.mean * static_cast<double>(before.count) +
                     last.mean * static_cast<double>(last.count)) /
                    static_cast<double>(count);
      before.count = count;
    }
  }
  std::vector<double> out;
  for (const Block& block : blocks) out.insert(out.end(), block.count, block.mean);
  return out;
}

/// The steps of one region.
class RegionSteps {
 public:
  RegionSteps(const std::vector<PressStep>& steps, int region, const std::vector<int>& region_of,
              Strength strength, const std::vector<double>& forces)
      : strength_(strength), forces_(forces) {
    for (const PressStep& step : steps) {
      if (region_of[static_cast<std::size_t>(step.area)] != region) continue;
      presses_[step.press].push_back(&step);
    }
  }

  PressResponse::Curve curve(const std::string& key) const {
    PressResponse::Curve out;
    for (std::size_t f = 0; f < forces_.size(); ++f) {
      out.rising.push_back(mean_at(f, true, key));
      out.falling.push_back(mean_at(f, false, key));
    }
    out.spread = spread();
    GroupedErrors steps_up(presses_.size());
    GroupedErrors loops(presses_.size());
    std::size_t group = 0;
    for (const auto& [press, steps] : presses_) {
      add_steps_up(steps, group, steps_up);
      add_loop(steps, group, loops);
      ++group;
    }
    out.monotone = steps_up.mean(key + "monotone");
    out.hysteresis = loops.mean(key + "hysteresis");
    return out;
  }

 private:
  using Press = std::vector<const PressStep*>;

  std::optional<Estimate> mean_at(std::size_t force, bool rising, const std::string& key) const {
    GroupedErrors values(presses_.size());
    std::size_t group = 0;
    for (const auto& [press, steps] : presses_) {
      for (const PressStep* step : steps) {
        const auto value = step->value(strength_);
        if (step->rising != rising || !value) continue;
        if (force_index(forces_, step->force_N) == force) values.add(group, *value);
      }
      ++group;
    }
    return values.mean(key + std::to_string(force) + (rising ? "up" : "down"));
  }

  /// Between the areas of the region, at the largest force.
  double spread() const {
    std::map<int, std::vector<double>> areas;
    for (const auto& [press, steps] : presses_) {
      for (const PressStep* step : steps) {
        const auto value = step->value(strength_);
        if (value && step->force_N == forces_.back()) areas[step->area].push_back(*value);
      }
    }
    std::vector<double> means;
    for (const auto& [area, values] : areas) means.push_back(mean(values));
    return means.size() < 2 ? 0 : sample_deviation(means) / std::abs(mean(means));
  }

  void add_steps_up(const Press& steps, std::size_t group, GroupedErrors& out) const {
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
      const auto a = steps[i]->value(strength_);
      const auto b = steps[i + 1]->value(strength_);
      if (!steps[i + 1]->rising || !a || !b) continue;
      out.add(group, *b > *a ? 1 : 0);
    }
  }

  /// Mean of falling less rising strength at the same force, over the span of the rising ones.
  void add_loop(const Press& steps, std::size_t group, GroupedErrors& out) const {
    std::map<std::size_t, double> rising;
    std::map<std::size_t, double> falling;
    for (const PressStep* step : steps) {
      const auto value = step->value(strength_);
      if (!value) continue;
      (step->rising ? rising : falling)[force_index(forces_, step->force_N)] = *value;
    }
    if (rising.size() < 2) return;
    const double span = rising.rbegin()->second - rising.begin()->second;
    double sum = 0;
    int count = 0;
    for (const auto& [force, value] : falling) {
      const auto up = rising.find(force);
      if (up == rising.end()) continue;
      sum += value - up->second;
      ++count;
    }
    if (count > 0 && span > 0) out.add(group, sum / count / span);
  }

  Strength strength_;
  const std::vector<double>& forces_;
  std::map<std::size_t, Press> presses_;
};

}  // namespace

ForceCalibration::ForceCalibration(const std::vector<PressStep>& steps, Strength strength,
                                   const std::vector<int>& region_of) {
  const int regions = *std::max_element(region_of.begin(), region_of.end()) + 1;
  regions_.resize(static_cast<std::size_t>(regions));
  for (int region = 0; region < regions; ++region) {
    std::map<double, std::vector<double>> by_force;
    for (const PressStep& step : steps) {
      const auto value = step.value(strength);
      if (value && region_of[static_cast<std::size_t>(step.area)] == region) {
        by_force[step.force_N].push_back(*value);
      }
    }
    std::vector<double> forces;
    std::vector<double> means;
    for (const auto& [force, values] : by_force) {
      forces.push_back(force);
      means.push_back(mean(values));
    }
    means = made_monotone(means);
    // Forces whose strengths are the same are told apart by nothing: their mean stands for them.
    std::vector<Knot>& knots = regions_[static_cast<std::size_t>(region)];
    for (std::size_t i = 0; i < means.size();) {
      std::size_t end = i;
      double force = 0;
      while (end < means.size() && means[end] == means[i]) force += forces[end++];
      knots.push_back({means[i], force / static_cast<double>(end - i)});
      i = end;
    }
  }
}

std::optional<double> ForceCalibration::force_N(int region, double strength) const {
  const std::vector<Knot>& knots = regions_[static_cast<std::size_t>(region)];
  if (knots.empty()) return std::nullopt;
  if (strength <= knots.front().strength) return knots.front().force;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    if (strength > knots[i + 1].strength) continue;
    const double part =
        (strength - knots[i].strength) / (knots[i + 1].strength - knots[i].strength);
    return knots[i].force + part * (knots[i + 1].force - knots[i].force);
  }
  return knots.back().force;
}

PressResponse press_response(const std::vector<PressStep>& steps,
                             const std::vector<PressStep>& calibration,
                             const std::vector<double>& forces_N, const std::vector<int>& region_of,
                             const std::string& key) {
  PressResponse out;
  const int regions = *std::max_element(region_of.begin(), region_of.end()) + 1;
  std::size_t presses = 0;
  for (const PressStep& step : steps) presses = std::max(presses, step.press + 1);
  for (const Strength strength : kStrengths) {
    PressResponse::Reading& reading = out.readings[static_cast<std::size_t>(strength)];
    for (int region = 0; region < regions; ++region) {
      const std::string name = key + name_of(strength) + std::to_string(region);
      reading.regions.push_back(
          RegionSteps(steps, region, region_of, strength, forces_N).curve(name));
    }
    const ForceCalibration force(calibration, strength, region_of);
    GroupedErrors all(presses);
    std::vector<GroupedErrors> at(forces_N.size(), GroupedErrors(presses));
    for (const PressStep& step : steps) {
      const auto value = step.value(strength);
      std::optional<double> read;
      if (value && step.found_area) {
        read = force.force_N(region_of[static_cast<std::size_t>(*step.found_area)], *value);
      }
      if (!read) {
        ++reading.unlocated;
        continue;
      }
      const double error = std::abs(*read - step.force_N);
      all.add(step.press, error);
      at[force_index(forces_N, step.force_N)].add(step.press, error);
    }
    const std::string name = key + name_of(strength);
    reading.force_error = all.mean(name + "force");
    for (std::size_t f = 0; f < forces_N.size(); ++f) {
      reading.force_error_at.push_back(at[f].mean(name + "force" + std::to_string(f)));
    }
  }
  return out;
}

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
