#include "bench/studies/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/report/report.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"
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
      step.step = static_cast<int>(s);
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

/// The mean of what the regions have, weighted alike.
std::optional<double> mean_over_regions(
    const PressResponse::Reading& reading,
    const std::function<std::optional<double>(const PressResponse::Curve&)>& of) {
  double sum = 0;
  int count = 0;
  for (const PressResponse::Curve& curve : reading.regions) {
    if (const auto value = of(curve)) {
      sum += *value;
      ++count;
    }
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

TableSection strength_table(const SensitivitySet& set, const std::string& law, double background) {
  TableSection table;
  table.caption = set.name + ": largest |δσ| over the background by region and force, rising; " +
                  set.condition + ", " + law + " law";
  table.columns = {{"solver", Align::left}, {"region", Align::left}};
  for (const double force : set.forces_N) table.columns.emplace_back(number_text(force) + " N");
  for (const PressResponse& solver : set.solvers) {
    if (!solver.failure.empty()) {
      std::vector<Cell> row(table.columns.size());
      row[0] = solver.label;
      row[1] = solver.failure;
      table.rows.push_back(std::move(row));
      continue;
    }
    const auto& regions = solver.readings[0].regions;
    for (std::size_t r = 0; r < regions.size(); ++r) {
      std::vector<Cell> row = {r == 0 ? solver.label : "", roman(static_cast<int>(r))};
      for (std::optional<Estimate> at : regions[r].rising) {
        if (at) {
          at = Estimate{at->value / background,
                        {at->ci95.low / background, at->ci95.high / background}};
        }
        row.push_back(estimate_cell(at, 3));
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

TableSection force_table(const SensitivitySet& set, const std::string& law) {
  TableSection table;
  table.caption = set.name + ": force after calibration; " + set.condition + ", " + law + " law, " +
                  std::to_string(set.presses) + " presses";
  table.columns = {{"solver", Align::left},
                   {"strength", Align::left},
                   {"mean error of force (N)"},
                   {"at " + number_text(set.forces_N.front()) + " N"},
                   {"at " + number_text(set.forces_N.back()) + " N"},
                   {"steps up that read higher"},
                   {"spread inside a region"},
                   {"hysteresis"},
                   {"unlocated steps"}};
  for (const PressResponse& solver : set.solvers) {
    if (!solver.failure.empty()) {
      table.rows.push_back({solver.label, solver.failure, {}, {}, {}, {}, {}, {}, {}});
      continue;
    }
    for (const Strength strength : kStrengths) {
      const auto& reading = solver.readings[static_cast<std::size_t>(strength)];
      const auto of_regions = [&](auto member, int decimals) {
        return number_cell(mean_over_regions(reading, member), decimals);
      };
      table.rows.push_back(
          {strength == Strength::peak ? solver.label : "", name_of(strength),
           estimate_cell(reading.force_error, 2), estimate_cell(reading.force_error_at.front(), 2),
           estimate_cell(reading.force_error_at.back(), 2),
           of_regions([](const PressResponse::Curve& c) { return value_of(c.monotone); }, 3),
           of_regions([](const PressResponse::Curve& c) { return std::optional(c.spread); }, 3),
           of_regions([](const PressResponse::Curve& c) { return value_of(c.hysteresis); }, 3),
           std::to_string(reading.unlocated)});
    }
  }
  return table;
}

/// All sets, a row a solver and strength, for programs.
TableSection response_rows(const std::vector<SensitivitySet>& sets) {
  TableSection rows;
  rows.columns = {{"set", Align::left}, {"solver", Align::left}, {"strength", Align::left}};
  for (const char* name : {"force_error_N", "least_force_error_N", "largest_force_error_N"}) {
    for (const Column& column : exact_columns(name)) rows.columns.push_back(column);
  }
  rows.columns.insert(rows.columns.end(), {{"monotone"},
                                           {"spread"},
                                           {"hysteresis"},
                                           {"unlocated"},
                                           {"corner_strength"},
                                           {"centre_strength"},
                                           {"failure"}});
  for (const SensitivitySet& set : sets) {
    for (const PressResponse& solver : set.solvers) {
      if (!solver.failure.empty()) {
        std::vector<Cell> row(rows.columns.size());
        row[0] = set.name;
        row[1] = solver.label;
        row.back() = solver.failure;
        rows.rows.push_back(std::move(row));
        continue;
      }
      for (const Strength strength : kStrengths) {
        const auto& reading = solver.readings[static_cast<std::size_t>(strength)];
        std::vector<Cell> row = {set.name, solver.label, name_of(strength)};
        for (const auto& error :
             {reading.force_error, reading.force_error_at.front(), reading.force_error_at.back()}) {
          for (const Cell& cell : exact_cells(error)) row.push_back(cell);
        }
        const auto of_regions = [&](auto member) {
          return exact_cell(mean_over_regions(reading, member));
        };
        row.push_back(
            of_regions([](const PressResponse::Curve& c) { return value_of(c.monotone); }));
        row.push_back(
            of_regions([](const PressResponse::Curve& c) { return std::optional(c.spread); }));
        row.push_back(
            of_regions([](const PressResponse::Curve& c) { return value_of(c.hysteresis); }));
        row.push_back(std::to_string(reading.unlocated));
        row.push_back(exact_cell(value_of(reading.regions.front().rising.back())));
        row.push_back(exact_cell(value_of(reading.regions.back().rising.back())));
        row.emplace_back();
        rows.rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

json json_of(const PressResponse& solver) {
  if (!solver.failure.empty()) return {{"failure", solver.failure}};
  json out;
  for (const Strength strength : kStrengths) {
    const auto& reading = solver.readings[static_cast<std::size_t>(strength)];
    json& one = out[name_of(strength)];
    one = {{"force_error_N", to_json(reading.force_error)},
           {"force_error_at_N", json::array()},
           {"unlocated_steps", reading.unlocated},
           {"regions", json::object()}};
    for (const auto& at : reading.force_error_at) one["force_error_at_N"].push_back(to_json(at));
    for (std::size_t r = 0; r < reading.regions.size(); ++r) {
      const PressResponse::Curve& curve = reading.regions[r];
      json& region = one["regions"][roman(static_cast<int>(r))];
      region = {{"rising", json::array()},
                {"falling", json::array()},
                {"spread", curve.spread},
                {"monotone", to_json(curve.monotone)},
                {"hysteresis", to_json(curve.hysteresis)}};
      for (const auto& at : curve.rising) region["rising"].push_back(to_json(at));
      for (const auto& at : curve.falling) region["falling"].push_back(to_json(at));
    }
  }
  return out;
}

}  // namespace

const char* name_of(Strength strength) { return strength == Strength::peak ? "peak" : "sum"; }

Sensitivity::Sensitivity(const StudyInput& input)
    : name_(input.spec.name),
      law_(input.law()),
      background_(input.experiment.sensor.background),
      region_of_(area_orbits(*input.experiment.sensor.sheet,
                             press_plan(input.set_spec(input.spec.sets.front())).areas)) {
  for (const std::string& set : input.spec.sets) {
    sets_.push_back(sensitivity_set(input, set, region_of_));
  }
}

json Sensitivity::summary() const {
  json out = {{"law", law_}, {"region_of_area", region_of_}};
  for (const SensitivitySet& set : sets_) {
    json& one = out["sets"][set.name];
    one = {{"condition", set.condition}, {"forces_N", set.forces_N}, {"presses", set.presses}};
    for (const PressResponse& solver : set.solvers) one["solvers"][solver.label] = json_of(solver);
  }
  return out;
}

std::vector<Headline> Sensitivity::headlines() const {
  std::vector<Headline> out;
  for (const SensitivitySet& set : sets_) {
    for (const PressResponse& solver : set.solvers) {
      if (!solver.failure.empty()) continue;
      for (const Strength strength : kStrengths) {
        const auto& reading = solver.readings[static_cast<std::size_t>(strength)];
        out.push_back({solver.label, set.name + ": force error by " + name_of(strength) + " (N)", 3,
                       value_of(reading.force_error)});
      }
    }
  }
  return out;
}

std::vector<ReportSection> Sensitivity::report(const std::string& title,
                                               const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Sensitivity to force (D.2)";
  section.text =
      "Each area of the sheet is pressed with growing and then with falling force; strengths are "
      "those at the end of each hold. Areas that the sheet's symmetries take into each other are a "
      "region. Peak: the largest |δσ| of the image; sum: its integral over the sheet. Force is "
      "read "
      "from the strength by a calibration of the region in which the touch was located, made on "
      "presses of its own. Steps up that read higher: of all steps up in force. Spread inside a "
      "region: standard deviation of its areas over their mean, at the largest force. Hysteresis: "
      "falling less rising strength at the same force, over the rising span. The last three are "
      "means over the regions; each region's own, with intervals, are in summary.json.";
  for (const SensitivitySet& set : sets_) {
    section.tables.push_back(force_table(set, law_));
    section.tables.push_back(strength_table(set, law_, background_));
    section.figures.push_back(sensitivity_curves(
        set, region_of_, background_, law_, without_law(title), folder / (name_ + "_" + set.name)));
    section.figures.push_back(
        force_errors(set, law_, without_law(title), folder / (name_ + "_force_" + set.name)));
  }
  write_study_tables({title, section.text, section.tables, {}, {}}, response_rows(sets_), folder,
                     name_);
  return {section};
}

}  // namespace ertbench
