#include "bench/studies/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "bench/studies/columns.h"
#include "bench/studies/drawing.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

const PressPlan& press_plan(const DatasetSpec& spec) {
  return std::get<PressPlan>(spec.sequences()->plan());
}

/// The last frame of each step of each press, with what the solver read out of it.
std::vector<PressStep> press_steps(const DatasetSpec& spec,
                                   const std::vector<FrameReading>& readings) {
  const SequenceSet& set = *spec.sequences();
  const PressPlan& plan = press_plan(spec);
  const std::vector<double> forces = plan.steps();
  const auto areas = static_cast<std::uint64_t>(plan.areas * plan.areas);
  std::vector<PressStep> out;
  for (std::uint64_t press = 0; press < set.sequences(); ++press) {
    for (std::size_t s = 0; s < forces.size(); ++s) {
      const double frames =
          std::floor(static_cast<double>(s + 1) * plan.hold_s * set.timing().frame_rate + 1e-6);
      if (frames < 1) continue;
      const std::uint64_t in_press =
          std::min(static_cast<std::uint64_t>(frames), set.frames_of(press)) - 1;
      const FrameReading& reading = readings.at(set.first_frame(press) + in_press);
      PressStep step;
      step.press = press;
      step.area = static_cast<int>(press % areas);
      step.force_N = forces[s];
      step.rising = s < plan.forces_N.size();
      if (reading.peak) step.peak = std::abs(*reading.peak);
      if (reading.sum) step.sum = std::abs(*reading.sum);
      if (reading.centroid25_mm) {
        step.found_area = area_of(*spec.sensor.sheet, *reading.centroid25_mm, plan.areas);
      }
      out.push_back(step);
    }
  }
  return out;
}

SensitivitySet sensitivity_set(const StudyInput& input, const std::string& name,
                               const std::vector<int>& region_of) {
  const DatasetSpec& spec = input.set_spec(name);
  const PressPlan& plan = press_plan(spec);
  SensitivitySet set;
  set.name = name;
  set.condition = plan.indenter.text() + ", " + noise_text(spec.noise);
  set.forces_N = plan.forces_N;
  set.presses = spec.sequences()->sequences();
  const std::string& calibration = input.spec.roles.at("calibration");
  for (const std::string& label : input.labels()) {
    const auto* readings = input.readings(label, name);
    const auto* known = input.readings(label, calibration);
    PressResponse response;
    if (readings && known) {
      response = press_response(press_steps(spec, *readings),
                                press_steps(input.set_spec(calibration), *known), plan.forces_N,
                                region_of, name + label);
    } else {
      response.failure = input.failure(label);
    }
    response.label = label;
    set.solvers.push_back(std::move(response));
  }
  return set;
}

using Reading = PressResponse::Reading;
using Curve = PressResponse::Curve;
using ResponseColumn = StudyColumn<Reading>;

const Reading& reading_of(const PressResponse& solver, Strength strength) {
  return solver.readings[static_cast<std::size_t>(strength)];
}

/// A number of the curves as its mean over the regions that have it, each with the same weight.
ResponseColumn of_regions(const std::string& key,
                          const std::function<std::optional<double>(const Curve&)>& value_in) {
  const auto mean_over_regions = [value_in](const Reading& reading) -> std::optional<double> {
    double sum = 0;
    int count = 0;
    for (const Curve& curve : reading.regions) {
      if (const auto value = value_in(curve)) {
        sum += *value;
        ++count;
      }
    }
    return count > 0 ? std::optional(sum / count) : std::nullopt;
  };
  return ResponseColumn::number(key, mean_over_regions, 3).data_only();
}

/// summary.json has the errors at all forces and the curves of all regions (json_of).
StudyColumns<Reading> response_columns(const std::vector<double>& forces_N) {
  const auto least = [](const Reading& r) { return r.force_error_at.front(); };
  const auto largest = [](const Reading& r) { return r.force_error_at.back(); };
  const auto corner = [](const Reading& r) { return value_of(r.regions.front().rising.back()); };
  const auto centre = [](const Reading& r) { return value_of(r.regions.back().rising.back()); };
  return {ResponseColumn::estimate("force_error_N", &Reading::force_error, 2)
              .table("mean error of force (N)"),
          ResponseColumn::estimate("least_force_error_N", least, 2)
              .data_only()
              .table("at " + number_text(forces_N.front()) + " N"),
          ResponseColumn::estimate("largest_force_error_N", largest, 2)
              .data_only()
              .table("at " + number_text(forces_N.back()) + " N"),
          of_regions("monotone", [](const Curve& c) { return value_of(c.monotone); })
              .table("steps up that read higher"),
          of_regions("spread", &Curve::spread).table("spread inside a region"),
          of_regions("hysteresis", [](const Curve& c) { return value_of(c.hysteresis); })
              .table("hysteresis"),
          ResponseColumn::count("unlocated_steps", &Reading::unlocated)
              .data("unlocated")
              .table("unlocated steps"),
          ResponseColumn::number("corner_strength", corner, 3).data_only(),
          ResponseColumn::number("centre_strength", centre, 3).data_only()};
}

/// In units of the background.
std::optional<Estimate> over(std::optional<Estimate> strength, double background) {
  if (!strength) return strength;
  return Estimate{strength->value / background,
                  {strength->ci95.low / background, strength->ci95.high / background}};
}

TableSection strength_table(const SensitivitySet& set, const std::string& law, double background) {
  TableSection table;
  table.caption = set.name + ": largest |δσ| over the background by region and force, rising; " +
                  set.condition + ", " + law + " law";
  table.columns = {{"solver", Align::left}, {"region", Align::left}};
  for (const double force : set.forces_N) table.columns.emplace_back(number_text(force) + " N");
  for (const PressResponse& solver : set.solvers) {
    if (add_failed(solver.label, solver.failure, table)) continue;
    const auto& regions = reading_of(solver, Strength::peak).regions;
    for (std::size_t r = 0; r < regions.size(); ++r) {
      std::vector<Cell> row = {r == 0 ? solver.label : "", roman(static_cast<int>(r))};
      for (const auto& at : regions[r].rising)
        row.push_back(estimate_cell(over(at, background), 3));
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

json json_of(const std::vector<std::optional<Estimate>>& estimates) {
  json out = json::array();
  for (const auto& estimate : estimates) out.push_back(to_json(estimate));
  return out;
}

json json_of(const Reading& reading, const StudyColumns<Reading>& columns) {
  json out = columns.json(reading);
  out["force_error_at_N"] = json_of(reading.force_error_at);
  out["regions"] = json::object();
  for (std::size_t r = 0; r < reading.regions.size(); ++r) {
    const Curve& curve = reading.regions[r];
    out["regions"][roman(static_cast<int>(r))] = {{"rising", json_of(curve.rising)},
                                                  {"falling", json_of(curve.falling)},
                                                  {"spread", curve.spread},
                                                  {"monotone", to_json(curve.monotone)},
                                                  {"hysteresis", to_json(curve.hysteresis)}};
  }
  return out;
}

/// Adds the set's table of forces, CSV rows, numbers and headlines.
void add_set(const SensitivitySet& set, const std::string& law, TableSection& rows, Study& study) {
  const StudyColumns<Reading> columns = response_columns(set.forces_N);
  TableSection& table = study.sections.front().report.tables.emplace_back();
  table.caption = set.name + ": force after calibration; " + set.condition + ", " + law + " law, " +
                  std::to_string(set.presses) + " presses";
  table.columns = columns.titles({{"solver", Align::left}, {"strength", Align::left}});
  if (rows.columns.empty()) {
    rows.columns =
        columns.names({{"set", Align::left}, {"solver", Align::left}, {"strength", Align::left}});
    rows.columns.emplace_back("failure");
  }
  json& numbers = study.numbers["sets"][set.name] = {
      {"condition", set.condition}, {"forces_N", set.forces_N}, {"presses", set.presses}};
  for (const PressResponse& solver : set.solvers) {
    json& own = numbers["solvers"][solver.label];
    if (add_failed(solver.label, solver.failure, table)) {
      own = {{"failure", solver.failure}};
      rows.rows.push_back({set.name, solver.label});
      rows.rows.back().resize(rows.columns.size());
      rows.rows.back().back() = solver.failure;
      continue;
    }
    for (const Strength strength : kStrengths) {
      const std::string by = name_of(strength);
      const Reading& reading = reading_of(solver, strength);
      table.rows.push_back(
          columns.cells({strength == Strength::peak ? solver.label : "", by}, reading));
      rows.rows.push_back(columns.data({set.name, solver.label, by}, reading));
      rows.rows.back().emplace_back();
      own[by] = json_of(reading, columns);
      study.best.push_back({solver.label, set.name + ": force error by " + by + " (N)", 3,
                            value_of(reading.force_error)});
    }
  }
}

MarkStyle region_mark(std::size_t region) { return {filled(region), hue(region), 0.6, 1.2}; }
LineStyle region_line(std::size_t region) {
  return {hue(region), 1.3, 1 + static_cast<int>(region % 3)};
}

/// The areas in the colours of their regions, numbered from the top left as in the paper.
void draw_regions(Canvas& canvas, const std::vector<int>& region_of, const Box& box) {
  const int areas = static_cast<int>(std::lround(std::sqrt(region_of.size())));
  const double cell = std::min(box.width(), box.height()) / areas;
  canvas.text("regions of the sheet", box.left + cell * areas / 2, box.top - 12, {.size = 11});
  for (int row = 0; row < areas; ++row) {
    for (int column = 0; column < areas; ++column) {
      const int region = region_of[static_cast<std::size_t>(column + areas * row)];
      const Box area =
          Box::sized(box.left + column * cell, box.top + (areas - 1 - row) * cell, cell, cell);
      canvas.rectangle(area, {.fill = hue(static_cast<std::size_t>(region)).towards_white(0.55),
                              .border = LineStyle{ink::dark, 0.8}});
      canvas.text(roman(region), area.middle(), area.centre(), {.size = 10});
    }
  }
}

/// The strengths over the background of one solver's regions.
void draw_strengths(Canvas& canvas, const Box& box, const SensitivitySet& set,
                    const PressResponse& solver, double background, const std::string& title) {
  const auto& regions = solver.readings[0].regions;
  Span span{0, 0};
  for (const Curve& curve : regions) {
    for (const auto& at : curve.rising) {
      if (at) span.extend(at->ci95.high / background);
    }
  }
  span.high = span.high > 0 ? 1.08 * span.high : 1;
  Panel axes(canvas, box, Axis::even({0, 1.05 * set.forces_N.back()}, "force, N"),
             Axis::even(span, title));
  axes.title(solver.label);
  add_failure(canvas, box, solver.failure);
  for (std::size_t r = 0; r < regions.size(); ++r) {
    Series series;
    for (std::size_t f = 0; f < set.forces_N.size(); ++f) {
      series.add(set.forces_N[f], over(regions[r].rising[f], background));
    }
    series.draw(axes, region_line(r), region_mark(r), {hue(r), 1});
  }
  axes.draw();
}

void draw_curves(const SensitivitySet& set, const std::vector<int>& region_of, double background,
                 const std::string& heading, const std::filesystem::path& stem) {
  const PanelGrid grid{.panels = static_cast<int>(set.solvers.size()) + 1,
                       .left = 60,
                       .top = 58,
                       .width = 214,
                       .height = 170,
                       .gap_x = 46,
                       .gap_y = 64};
  Canvas canvas(grid.right() - 20, grid.bottom() + 44);
  canvas.title(heading);
  int panel = 0;
  for (const PressResponse& solver : set.solvers) {
    draw_strengths(canvas, grid.box(panel), set, solver, background,
                   panel % grid.columns() == 0 ? "largest |δσ| / background" : "");
    ++panel;
  }
  draw_regions(canvas, region_of, grid.box(panel));
  Legend legend(grid.left, canvas.width() - 10);
  const int regions = 1 + *std::ranges::max_element(region_of);
  for (int r = 0; r < regions; ++r) {
    const auto region = static_cast<std::size_t>(r);
    legend.add({"region " + roman(r), region_line(region), region_mark(region)});
  }
  legend.draw(canvas, canvas.height() - 32);
  add_footnote(
      canvas,
      "while the force is raised; each panel has its own scale; bars: 95 % interval of the mean",
      grid.left);
  canvas.draw(stem);
}

/// The largest |δσ| over the background against the force, a panel a solver, a line a region, and
/// the map of the regions: the paper's figures D3 and D2.
StudyFigure figure_of(const std::shared_ptr<const SensitivitySet>& set,
                      const std::vector<int>& region_of, double background,
                      const std::string& law) {
  const std::string condition = set->condition + ", " + law + " law";
  return {"_" + set->name, "Strength against force by region, " + set->name, condition,
          ": strength of the image, " + condition,
          [set, region_of, background](const auto& heading, const auto& stem) {
            draw_curves(*set, region_of, background, heading, stem);
          }};
}

}  // namespace

const char* name_of(Strength strength) { return strength == Strength::peak ? "peak" : "sum"; }

Study sensitivity_study(const StudyInput& input) {
  const std::string law = input.law();
  const double background = input.experiment.sensor.background;
  const std::vector<int> region_of = area_orbits(
      *input.experiment.sensor.sheet, press_plan(input.set_spec(input.spec.sets.front())).areas);
  const auto sets = std::make_shared<std::vector<SensitivitySet>>();
  for (const std::string& set : input.spec.sets) {
    sets->push_back(sensitivity_set(input, set, region_of));
  }

  Study study(input.spec.name, "Sensitivity to force (D.2)",
              {{"law", law}, {"region_of_area", region_of}});
  StudySection& section = study.sections.front();
  section.report.text =
      "Each area of the sheet is pressed with growing and then with falling force; strengths are "
      "those at the end of each hold. Areas that the sheet's symmetries take into each other are a "
      "region. Peak: the largest |δσ| of the image; sum: its integral over the sheet. Force is "
      "read from the strength by a calibration of the region in which the touch was located, made "
      "on presses of its own. Steps up that read higher: of all steps up in force. Spread inside a "
      "region: standard deviation of its areas over their mean, at the largest force. Hysteresis: "
      "falling less rising strength at the same force, over the rising span. The last three are "
      "means over the regions; each region's own, with intervals, are in summary.json.";
  TableSection rows;
  for (const SensitivitySet& set : *sets) {
    const std::shared_ptr<const SensitivitySet> one(sets, &set);
    add_set(set, law, rows, study);
    section.report.tables.push_back(strength_table(set, law, background));
    section.figures.push_back(figure_of(one, region_of, background, law));
  }
  section.data = {{"", rows}};
  return study;
}

}  // namespace ertbench
