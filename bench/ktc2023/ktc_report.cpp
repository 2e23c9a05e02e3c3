#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/ktc2023/ktc_experiment.h"
#include "bench/plot/canvas.h"
#include "bench/record/record_file.h"
#include "bench/table/table.h"
#include "core/files.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string percent(double share) { return three_digits(100 * share) + " %"; }

TableSection scores_of(const std::string& caption, const std::vector<KtcRow>& rows) {
  TableSection out;
  out.caption = caption;
  out.columns = {{"method", Align::left}, "sum of 21"};
  for (int level = 1; level <= ktc_levels; ++level) {
    out.columns.emplace_back("level " + std::to_string(level));
  }
  out.columns.emplace_back("time of a target");
  for (const KtcRow& row : rows) {
    std::vector<Cell>& cells = out.rows.emplace_back();
    cells = {row.label, number_cell(row.sum(), 2)};
    for (int level = 1; level <= ktc_levels; ++level) {
      cells.push_back(number_cell(row.score_of(level), 2));
    }
    const double time = row.median_time_s();
    cells.emplace_back(time > 0 ? three_digits(1000 * time) + " ms" : "—");
  }
  return out;
}

TableSection official_of(const KtcResults& results) {
  TableSection out;
  out.caption = "The competition's own results, on its evaluation targets";
  out.columns = scores_of("", {}).columns;
  out.columns.pop_back();
  for (const auto& [label, values] : results.official) {
    std::vector<Cell>& cells = out.rows.emplace_back();
    double sum = 0;
    for (const double value : values) sum += value;
    cells = {label, number_cell(sum, 2)};
    for (std::size_t level = 0; level < ktc_levels; ++level) {
      cells.push_back(values.size() > 1 ? number_cell(values[level], 2) : Cell("—"));
    }
  }
  return out;
}

TableSection calibration_of(const KtcResults& results) {
  TableSection out;
  out.caption = "What the model does not explain of the empty tank";
  out.columns = {{"reference", Align::left},
                 "conductivity",
                 "with impedances",
                 "with common mode",
                 "with gains",
                 "same drive again",
                 "drive reversed"};
  for (const auto& [file, fit] : results.calibrations) {
    std::vector<Cell>& cells = out.rows.emplace_back();
    cells.emplace_back(file);
    for (const double share : fit.unexplained) cells.emplace_back(percent(share));
    cells.emplace_back(percent(fit.repeated));
    cells.emplace_back(percent(fit.reversed));
  }
  return out;
}

Table table_of(const KtcResults& results) {
  Table table;
  table.title = results.title;
  table.text = results.question;
  table.sections = {scores_of(
      results.simulated_levels ? "Scores on the training targets" : "Scores", results.rows)};
  if (!results.simulated.empty()) {
    table.sections.push_back(scores_of("Scores on simulated targets", results.simulated));
  }
  if (!results.official.empty()) table.sections.push_back(official_of(results));
  table.sections.push_back(calibration_of(results));
  table.legend = {
      "A level's score is three times the mean over its targets; 3 is the most. Segmentation is "
      "the method's own, or by Otsu's two thresholds where it has none or the row says so.",
      "Unexplained: norm of the residual over that of the reference's voltages, both per mA. The "
      "last two columns compare repeated drives without any model.",
      "Times are medians, one thread of " + cpu_name() + ", calibration not included."};
  if (results.simulated_levels) {
    table.legend.push_back(
        "The targets are those of the training set. Levels are simulated: channels of electrodes 1 "
        "to 2(level - 1) are left out. The evaluation's targets are others.");
  }
  table.command = results.command;
  return table;
}

TableSection targets_of(const KtcResults& results) {
  TableSection out;
  out.columns = columns_named("method target level score time_ms");
  for (const auto* rows : {&results.rows, &results.simulated}) {
    for (const KtcRow& row : *rows) {
      for (const KtcOutcome& one : row.outcomes) {
        out.rows.push_back({row.label, one.target, std::to_string(one.level), exact_cell(one.score),
                            exact_cell(1000 * one.time_s)});
      }
    }
  }
  return out;
}

json rows_of(const std::vector<KtcRow>& rows) {
  json out = json::array();
  for (const KtcRow& row : rows) {
    json levels = json::array();
    for (int level = 1; level <= ktc_levels; ++level) {
      const auto score = row.score_of(level);
      levels.push_back(score ? json(*score) : json());
    }
    const auto sum = row.sum();
    out.push_back({{"label", row.label},
                   {"sum", sum ? json(*sum) : json()},
                   {"levels", levels},
                   {"time_ms", 1000 * row.median_time_s()}});
  }
  return out;
}

json summary_of(const KtcResults& results) {
  json out = {{"schema", 1},
              {"title", results.title},
              {"command", results.command},
              {"machine", machine_provenance()}};
  out["rows"] = rows_of(results.rows);
  if (!results.simulated.empty()) out["simulated"] = rows_of(results.simulated);
  for (const auto& [file, fit] : results.calibrations) {
    out["calibration"][file] = {
        {"conductivity", fit.conductivity},
        {"contact_impedance",
         std::vector<double>(fit.contact_impedance.begin(), fit.contact_impedance.end())},
        {"unexplained", fit.unexplained},
        {"repeated", fit.repeated},
        {"reversed", fit.reversed}};
  }
  return out;
}

constexpr int shown_size = 128;   ///< of an image in the figure
constexpr int shown_pitch = 140;  ///< from one to the next

/// Puts a map of the tank among the values of the figure.
void put(const ClassMap& map, Eigen::Index top, Eigen::Index left, Eigen::MatrixXi& values) {
  constexpr double half = shown_size / 2.0;
  const auto each = map.rows() / shown_size;
  for (int y = 0; y < shown_size; ++y) {
    for (int x = 0; x < shown_size; ++x) {
      const double dx = (x + 0.5) / half - 1;
      const double dy = (y + 0.5) / half - 1;
      if (dx * dx + dy * dy < 1) values(top + y, left + x + 6) = map(y * each, x * each);
    }
  }
}

/// All targets of a row below their truths, a column for each level.
void draw_targets(const KtcRow& row, const std::string& title, const fs::path& stem) {
  constexpr double left = 44;
  constexpr double top = 54;
  constexpr double cell = 66;
  std::map<int, std::vector<const KtcOutcome*>> by_level;
  for (const KtcOutcome& one : row.outcomes) by_level[one.level].push_back(&one);
  std::size_t deepest = 0;
  for (const auto& [level, targets] : by_level) deepest = std::max(deepest, targets.size());
  const double width = cell * static_cast<double>(by_level.size());
  const double height = cell * 2 * static_cast<double>(deepest);
  constexpr int outside = -1;
  Eigen::MatrixXi values =
      Eigen::MatrixXi::Constant(static_cast<Eigen::Index>(2 * deepest) * shown_pitch,
                                std::ssize(by_level) * shown_pitch, outside);
  Canvas canvas(left + width + 8, top + height + 8);
  canvas.title(title);
  double x = left + cell / 2;
  Eigen::Index column = 0;
  for (const auto& [level, targets] : by_level) {
    canvas.text("level " + std::to_string(level), x, top - 9);
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const auto line = static_cast<Eigen::Index>(2 * t) * shown_pitch;
      if (targets[t]->truth) put(*targets[t]->truth, line, column, values);
      put(targets[t]->classes, line + shown_pitch, column, values);
      if (!targets[t]->score) continue;
      canvas.text(fixed(*targets[t]->score, 2), x + cell / 2,
                  top + cell * (2.0 * static_cast<double>(t) + 2) - 6,
                  {.size = 8, .align = TextAlign::right, .colour = ink::note});
    }
    x += cell;
    column += shown_pitch;
  }
  for (std::size_t t = 0; t < 2 * deepest; ++t) {
    canvas.text(t % 2 == 0 ? "truth" : "image", left - 5,
                top + cell * (static_cast<double>(t) + 0.5), {.align = TextAlign::right});
  }
  TextStream text;
  for (const auto& line : values.rowwise()) text << line << '\n';
  canvas.area(Box::sized(left, top, width, height));
  canvas.plots() << "set palette maxcolors 4 defined (-1 'white', 0 '#dde6ee', 1 '#0072b2', "
                    "2 '#d55e00')\n"
                 << "unset key\nunset tics\nunset colorbox\nunset border\nset cbrange [-1:2]\n"
                 << "set xrange [-0.5:" << values.cols() << " - 0.5]\nset yrange [" << values.rows()
                 << " - 0.5:-0.5]\nplot " << canvas.data(text.str()) << " matrix with image\n";
  canvas.draw(stem);
}

}  // namespace

std::size_t report_ktc(const KtcResults& results, const fs::path& folder) {
  fs::create_directories(folder);
  const Table table = table_of(results);
  const KtcRow& best = *std::ranges::max_element(
      results.rows,
      [](const KtcRow& a, const KtcRow& b) { return a.mean_score() < b.mean_score(); });
  write_file_atomically(folder / "table.md",
                        markdown_of(table) + "\n![All targets](targets.png)\n\nAll targets by " +
                            best.label + ": water grey, resistive blue, conductive orange.\n");
  write_file_atomically(folder / "targets.csv", csv_of(targets_of(results)));
  write_file_atomically(folder / "scores.json", json_text(summary_of(results), 1) + "\n");
  const fs::path figure = folder / "targets";
  const bool drawn =
      draw_or_say(figure, [&] { draw_targets(best, "KTC2023 by " + best.label, figure); });
  std::printf("%s\nResults in %s\n", terminal_of(table).c_str(),
              printable_path(folder.string()).c_str());
  return drawn ? 0 : 1;
}

}  // namespace ertbench
