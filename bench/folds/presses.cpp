#include "bench/folds/presses.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "bench/studies/columns.h"
#include "bench/studies/drawing.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

constexpr std::size_t most_strengths = 6;  ///< that get rows of their own
constexpr int rings = 4;

using Held = std::vector<HeldOutPress>;

PressErrors errors_of(const Held& presses, const Vector2d& middle, const std::string& title,
                      const std::string& key) {
  PressErrors out;
  out.title = title;
  out.presses = presses.size();
  GroupedErrors errors(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    errors.add(i, (presses[i].found_mm.value_or(middle) - presses[i].place_mm).norm());
    out.missed += !presses[i].found_mm.has_value();
  }
  out.mean = errors.mean(key + "mean");
  out.median = errors.quantile(0.5, key + "median");
  out.p95 = errors.quantile(0.95, key + "p95");
  out.worst = errors.worst();
  return out;
}

Held select(Held presses, const std::function<bool(const HeldOutPress&)>& wanted) {
  std::erase_if(presses, std::not_fn(wanted));
  return presses;
}

/// Properties that the parts of a level share.
struct Division {
  Vector2d middle;
  double radius_mm;
  std::string strength_name;  ///< empty: all presses are alike
  double unit_strength;
};

std::vector<PressErrors> by_strength(const Held& presses, const Division& division,
                                     const std::string& key) {
  std::vector<PressErrors> out;
  if (division.strength_name.empty()) return out;
  std::set<double> strengths;
  for (const HeldOutPress& press : presses) {
    strengths.insert(std::round(1e6 * press.strength * division.unit_strength) / 1e6);
  }
  if (strengths.size() > most_strengths) return out;
  for (const double strength : strengths) {
    const Held part = select(presses, [&](const HeldOutPress& press) {
      return std::abs(press.strength * division.unit_strength - strength) < 1e-5 * strength;
    });
    const std::string title = division.strength_name + " " + number_text(strength);
    out.push_back(errors_of(part, division.middle, title, key + title));
  }
  return out;
}

std::vector<PressErrors> by_place(const Held& presses, const Division& division,
                                  const std::string& key) {
  std::vector<PressErrors> out;
  for (int ring = 0; ring < rings; ++ring) {
    const double low = division.radius_mm * ring / rings;
    const double high = division.radius_mm * (ring + 1) / rings;
    const Held part = select(presses, [&](const HeldOutPress& press) {
      const double from = (press.place_mm - division.middle).norm();
      return from >= low && (from < high || ring == rings - 1);
    });
    if (part.empty()) continue;
    const std::string title = fixed(low, 0) + " to " + fixed(high, 0) + " mm";
    out.push_back(errors_of(part, division.middle, title, key + title));
  }
  return out;
}

/// |error| of the strength in the file's units; a missed press counts as strength 0.
std::optional<Estimate> strength_error(const Held& presses, const Division& division,
                                       const std::string& key) {
  if (division.strength_name.empty()) return std::nullopt;
  GroupedErrors errors(presses.size());
  for (std::size_t i = 0; i < presses.size(); ++i) {
    errors.add(i,
               std::abs(presses[i].found_strength - presses[i].strength) * division.unit_strength);
  }
  return errors.mean(key + "strength");
}

PressSolver solver_of(const FoldsOutcome& outcome, const std::vector<std::uint64_t>& numbers,
                      const Division& division) {
  PressSolver solver{outcome.label, outcome.failure, {}, {}};
  for (std::size_t level = 0; level < numbers.size(); ++level) {
    PressLevel& one = solver.levels.emplace_back();
    one.presses = numbers[level];
    one.failure = outcome.failure;
    Held held;
    int runs = 0;
    for (const FoldRecord& fold : outcome.folds) {
      if (level >= fold.size()) continue;  // not run, or a skin with fewer presses
      const FoldRun& run = fold[level];
      ++runs;
      if (!run.message.empty() && one.failure.empty()) one.failure = run.message;
      const Held& own = run.held_out;
      if (own.empty()) continue;
      one.fold_means.push_back(errors_of(own, division.middle, "", "").mean->value);
      one.fit_s += run.fit_s;
      held.insert(held.end(), own.begin(), own.end());
    }
    if (held.empty()) continue;
    one.fit_s /= runs;
    const std::string key = outcome.label + std::to_string(one.presses);
    one.all = errors_of(held, division.middle, "", key);
    one.by_strength = by_strength(held, division, key);
    one.by_place = by_place(held, division, key);
    one.strength = strength_error(held, division, key);
    if (level + 1 == numbers.size()) solver.held_out = held;
  }
  return solver;
}

using PressColumn = StudyColumn<PressErrors>;

const StudyColumns<PressErrors> press_columns = {
    PressColumn::estimate("mean_mm", &PressErrors::mean, 2).table("mean"),
    PressColumn::estimate("median_mm", &PressErrors::median, 2).table("median"),
    PressColumn::estimate("p95_mm", &PressErrors::p95, 2).table("95 %"),
    PressColumn::number("worst_mm", &PressErrors::worst, 1).table("worst"),
    PressColumn::count("missed", &PressErrors::missed).table("missed"),
    PressColumn::count("presses", &PressErrors::presses).data("held_out")};

json json_of(const PressErrors& errors) {
  json out = press_columns.json(errors);
  if (!errors.title.empty()) out["part"] = errors.title;
  return out;
}

json json_of(const PressLevel& level) {
  json out = json_of(level.all);
  out["fold_means_mm"] = level.fold_means;
  out["fit_s"] = level.fit_s;
  if (!level.failure.empty()) out["failure"] = level.failure;
  if (level.strength) out["strength_error"] = to_json(level.strength);
  for (const PressErrors& part : level.by_strength) out["by_strength"].push_back(json_of(part));
  for (const PressErrors& part : level.by_place) out["by_place"].push_back(json_of(part));
  return out;
}

json json_of(const PressSolver& solver) {
  json out = json::object();
  if (!solver.failure.empty()) out["failure"] = solver.failure;
  for (const PressLevel& level : solver.levels) {
    out["after"][std::to_string(level.presses)] = json_of(level);
  }
  return out;
}

/// Errors of guessing the middle of the sheet and the mean strength, on the presses of the solver
/// that was tried on the most.
void guess_the_middle(const Division& division, PressResults& results) {
  for (const PressSolver& solver : results.solvers) {
    if (solver.held_out.empty() || results.middle.presses >= solver.held_out.size()) continue;
    Held guessed = solver.held_out;
    double mean = 0;
    for (HeldOutPress& press : guessed) {
      press.found_mm = division.middle;
      mean += press.strength / static_cast<double>(guessed.size());
    }
    for (HeldOutPress& press : guessed) press.found_strength = mean;
    results.middle = errors_of(guessed, division.middle, "", "middle");
    results.mean_strength = strength_error(guessed, division, "middle");
  }
}

/// Errors after the most presses, a row a solver.
TableSection errors_table(const PressResults& results, const std::string& strength_name,
                          std::uint64_t presses) {
  TableSection table;
  table.caption = "after " + std::to_string(presses) + " presses; errors in mm";
  table.columns = press_columns.titles({{"solver", Align::left}});
  if (!strength_name.empty()) table.columns.push_back({"|error| of " + strength_name});
  const auto add = [&](const Cell& label, const PressErrors& errors,
                       const std::optional<Estimate>& strength) {
    table.rows.push_back(press_columns.cells({label}, errors));
    if (!strength_name.empty()) table.rows.back().push_back(estimate_cell(strength, 2));
  };
  for (const PressSolver& solver : results.solvers) {
    const PressLevel& level = solver.levels.back();
    Cell label = solver.label;
    if (!level.failure.empty()) label.lines.push_back(one_line(level.failure, 80));
    add(label, level.all, level.strength);
  }
  add("middle of the sheet", results.middle, results.mean_strength);
  return table;
}

/// Errors after the most presses by strength and distance; no rows where there are no parts.
TableSection parts_table(const PressResults& results) {
  TableSection table;
  table.caption = "the same by strength and by distance from the middle";
  table.columns = press_columns.titles({{"solver", Align::left}, {"presses", Align::left}});
  for (const PressSolver& solver : results.solvers) {
    const PressLevel& level = solver.levels.back();
    for (const auto* division : {&level.by_strength, &level.by_place}) {
      for (const PressErrors& part : *division) {
        table.rows.push_back(press_columns.cells({solver.label, part.title}, part));
      }
    }
  }
  return table;
}

/// The CSV file: a row for each solver, number of presses and part.
TableSection press_rows(const PressResults& results) {
  TableSection rows;
  rows.columns = press_columns.names({{"solver", Align::left}, {"presses"}, {"part", Align::left}});
  for (const char* end : {"", "_low", "_high"}) {
    rows.columns.emplace_back(std::string("strength_error") + end);
  }
  const auto add = [&](const std::string& label, std::uint64_t learned_from,
                       const PressErrors& errors, const std::optional<Estimate>& strength) {
    const std::string part = errors.title.empty() ? "all" : errors.title;
    rows.rows.push_back(press_columns.data({label, std::to_string(learned_from), part}, errors));
    for (const Cell& cell : exact_cells(strength)) rows.rows.back().push_back(cell);
  };
  add("middle of the sheet", 0, results.middle, results.mean_strength);
  for (const PressSolver& solver : results.solvers) {
    for (const PressLevel& level : solver.levels) {
      add(solver.label, level.presses, level.all, level.strength);
      for (const auto* division : {&level.by_strength, &level.by_place}) {
        for (const PressErrors& part : *division) {
          add(solver.label, level.presses, part, std::nullopt);
        }
      }
    }
  }
  return rows;
}

void draw_curve(const PressResults& results, const std::string& heading,
                const std::filesystem::path& stem) {
  const std::vector<PressSolver>& solvers = results.solvers;
  constexpr double width = 700;
  constexpr double height = 380;
  constexpr double left = 64;
  const MethodStyles styles = styles_of(solvers);
  Legend legend(left, left + width);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    legend.add({solvers[s].label, styles.line(s, 1.6), styles.mark(s, 0.9)});
  }
  const LineStyle guess{ink::black, 1.4, 2};
  legend.add({"the middle of the sheet, always", guess});
  Canvas canvas(left + width + 20, 40 + height + 80 + legend.height());
  canvas.title(heading);
  const Box box = Box::sized(left, 40, width, height);
  Span across;
  std::vector<Tick> ticks;
  for (const PressLevel& level : solvers.front().levels) {
    across.extend(static_cast<double>(level.presses));
    ticks.push_back({static_cast<double>(level.presses), std::to_string(level.presses)});
  }
  Span up;
  if (results.middle.mean) up.extend(results.middle.mean->value);
  for (const PressSolver& solver : solvers) {
    for (const PressLevel& level : solver.levels) {
      for (const double mean : level.fold_means) up.extend(std::max(0.01, mean));
    }
  }
  Axis x = Axis::logarithms({across.low / 1.15, across.high * 1.15}, "presses learned from");
  x.ticks = ticks;
  const Span errors = up.empty() ? Span{1, 100} : Span{up.low / 1.3, up.high * 1.3};
  Panel axes(canvas, box, x, Axis::logarithms(errors, "localisation error, mm"));
  if (results.middle.mean) axes.level(results.middle.mean->value, guess);
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    // Side by side, so that no band hides another.
    const double shift =
        std::pow(1.012, static_cast<double>(s) - (static_cast<double>(solvers.size()) - 1) / 2);
    Series series;
    for (const PressLevel& level : solvers[s].levels) {
      if (!level.all.mean) continue;
      const double at = shift * static_cast<double>(level.presses);
      const double mean = std::max(0.01, level.all.mean->value);
      series.points.emplace_back(at, mean);
      const auto [low, high] = std::ranges::minmax_element(level.fold_means);
      series.whiskers.push_back({at, std::max(0.01, *low), std::max(0.01, *high)});
      axes.tooltip(at, mean,
                   solvers[s].label + "\n" + std::to_string(level.presses) + " presses\nmean " +
                       fixed(mean, 2) + " mm, folds " + fixed(*low, 2) + " to " + fixed(*high, 2));
    }
    series.draw(axes, styles.line(s, 1.6), styles.mark(s, 0.9), {styles.colour(s), 1.2});
  }
  axes.draw();
  legend.draw(canvas, box.bottom + 56);
  add_footnote(
      canvas,
      "marks: mean over all presses, each held out once; bars: least and largest mean of a fold",
      left);
  canvas.draw(stem);
}

/// Folds [first, last) of all solvers, on the sheet of one skin.
std::shared_ptr<PressResults> results_of(const Folds& folds,
                                         const std::vector<FoldsOutcome>& outcomes, int first,
                                         int last, const Division& division) {
  std::vector<std::uint64_t> numbers = folds.presses;
  std::uint64_t most = 0;
  for (int fold = first; fold < last; ++fold) {
    most = std::max(most, folds.most(folds.skin_of(fold)));
  }
  std::erase_if(numbers, [&](std::uint64_t number) { return number > most; });
  auto results = std::make_shared<PressResults>();
  for (FoldsOutcome outcome : outcomes) {
    outcome.folds.resize(static_cast<std::size_t>(folds.total()));
    outcome.folds = {outcome.folds.begin() + first, outcome.folds.begin() + last};
    results->solvers.push_back(solver_of(outcome, numbers, division));
  }
  guess_the_middle(division, *results);
  return results;
}

/// Mean, with the median below it, by number of presses.
TableSection levels_table(const PressResults& results) {
  TableSection table;
  table.caption = "mean localisation error, mm, by the presses learned from; below it the median";
  table.columns = {{"solver", Align::left}};
  for (const PressLevel& level : results.solvers.front().levels) {
    table.columns.emplace_back(std::to_string(level.presses));
  }
  for (const PressSolver& solver : results.solvers) {
    std::vector<Cell>& row = table.rows.emplace_back(std::vector<Cell>{solver.label});
    for (const PressLevel& level : solver.levels) {
      row.push_back(estimate_cell(level.all.mean, 2));
      const Cell median = estimate_cell(level.all.median, 2);
      row.back().lines.push_back(median.text + " " + median.interval);
    }
  }
  return table;
}

Division division_of(const DatasetSpec& skin) {
  const double mm = skin.sensor.sheet->unit_mm();
  Division out{skin.sensor.sheet->bounds().center() * mm, skin.sensor.sheet->radius() * mm, "", 1};
  const MeasuredFrames& frames = *skin.measured();
  if (!frames.strength_of.empty()) {
    out.strength_name = frames.strength_of.substr(frames.strength_of.find_last_of('/') + 1);
    out.unit_strength = frames.full_strength / (1 - frames.conductivity_ratio);
  }
  return out;
}

json numbers_of(const PressResults& results) {
  json out = {{"middle", json_of(results.middle)}, {"solvers", json::object()}};
  for (const PressSolver& solver : results.solvers) {
    out["solvers"][solver.label] = json_of(solver);
  }
  return out;
}

/// Tables and figures of one skin, or of all.
StudySection section_of(const std::shared_ptr<const PressResults>& results, const Folds& folds,
                        const Division& division, const std::string& of) {
  StudySection section;
  section.report.text =
      "Distance of the detected contact from the position that was pressed, on presses that the "
      "solver has not seen: the frames of " +
      of + " in " + std::to_string(folds.count) +
      " folds. A solver that images is read by the strongest contact of its image. A missed press "
      "counts as guessed in the middle of the sheet. Intervals: 95 %, by the "
      "bootstrap over presses.";
  if (!division.strength_name.empty()) {
    section.report.text += " " + division.strength_name +
                           " is read from the contact's strength, in which the targets are linear.";
  }
  const auto& levels = results->solvers.front().levels;
  auto& tables = section.report.tables;
  if (levels.size() > 1) tables.push_back(levels_table(*results));
  tables.push_back(errors_table(*results, division.strength_name, levels.back().presses));
  if (TableSection parts = parts_table(*results); !parts.rows.empty()) tables.push_back(parts);
  section.figures = {
      {"_curve", "Error by the number of presses",
       "mean localisation error on presses that were not learned from", "",
       [results](const auto& heading, const auto& stem) { draw_curve(*results, heading, stem); }}};
  section.data = {{"", press_rows(*results)}};
  return section;
}

}  // namespace

Study presses_study(const Folds& folds, const std::vector<FoldsOutcome>& outcomes) {
  Study study;
  study.name = "presses";
  const bool several = folds.skins.size() > 1;
  const auto add = [&](const DatasetSpec& shown, int first, int last, const std::string& of) {
    const Division division = division_of(shown);
    const auto results = results_of(folds, outcomes, first, last, division);
    json numbers = numbers_of(*results);
    study.sections.push_back(section_of(results, folds, division, of));
    if (!division.strength_name.empty()) {
      numbers["strength"] = division.strength_name;
      numbers["mean_strength_error"] = to_json(results->mean_strength);
    }
    return numbers;
  };
  const auto wider = [](const DatasetSpec& a, const DatasetSpec& b) {
    return division_of(a).radius_mm < division_of(b).radius_mm;
  };
  const DatasetSpec& widest = *std::ranges::max_element(folds.skins, wider);
  study.numbers =
      add(widest, 0, folds.total(),
          several ? std::to_string(folds.skins.size()) + " skins" : widest.measured()->name);
  study.sections[0].report.title = "Presses (D.1 on measured frames)";
  study.numbers["file"] = widest.measured()->name;
  study.numbers["folds"] = folds.count;
  study.numbers["presses"] = folds.presses;
  for (int s = 0; several && s < std::ssize(folds.skins); ++s) {
    const DatasetSpec& skin = folds.skins[static_cast<std::size_t>(s)];
    const std::string& name = skin.measured()->name;
    study.numbers["skins"][name] = add(skin, s * folds.count, (s + 1) * folds.count, name);
    StudySection& section = study.sections.back();
    section.part = "_" + std::filesystem::path(name).stem().string();
    for (StudyFigure& figure : section.figures) figure.part = section.part + figure.part;
    section.subject = ", " + name;
    section.report.title = "Presses on " + name;
  }
  return study;
}

}  // namespace ertbench
