#include "bench/studies/tracking_tables.h"

#include <algorithm>
#include <utility>

#include "core/text.h"

namespace ertbench {
namespace {

struct TrackingColumn {
  const char* title;  ///< of a table
  const char* name;   ///< of data
  std::optional<Estimate> TrackingScores::*score;
  double factor;  ///< from the score to what a table shows
  int decimals;
  int TrackingScores::*characters = nullptr;  ///< that have the value, where not all need to
};

const TrackingColumn tracking_columns[] = {
    {"RMS (mm)", "rms_mm", &TrackingScores::rms_mm, 1, 1, &TrackingScores::with_rms},
    {"RMS without lag (mm)", "rms_without_lag_mm", &TrackingScores::rms_without_lag_mm, 1, 1,
     &TrackingScores::with_lag},
    {"lag (ms)", "lag_ms", &TrackingScores::lag_ms, 1, 1, &TrackingScores::with_lag},
    {"Fréchet (mm)", "frechet_mm", &TrackingScores::frechet_mm, 1, 1,
     &TrackingScores::with_frechet},
    {"drop-outs (%)", "drop_outs", &TrackingScores::drop_outs, 100, 1},
    {"dropped frames (%)", "dropped_frames", &TrackingScores::dropped_frames, 100, 1},
    {"ghosts (in 100 frames)", "ghosts", &TrackingScores::ghosts, 100, 1},
    {"read back (%)", "read_back", &TrackingScores::read_back, 100, 1},
};

Cell tracking_score_cell(const TrackingOfSolver& solver, const TrackingColumn& column) {
  std::optional<Estimate> shown = solver.scores.*column.score;
  if (shown) {
    shown->value *= column.factor;
    shown->ci95 = {column.factor * shown->ci95.low, column.factor * shown->ci95.high};
  }
  Cell cell = estimate_cell(shown, column.decimals);
  const int all = static_cast<int>(solver.characters.size());
  if (column.characters && solver.scores.*column.characters < all) {
    cell.lines.push_back("of " + std::to_string(solver.scores.*column.characters) + " of " +
                         std::to_string(all));
  }
  return cell;
}

Cell tracking_latency_cell(const TrackingOfSolver& solver) {
  if (solver.latency_s) return number_cell(1000 * *solver.latency_s, 3);
  Cell cell = number_cell(std::nullopt, 3);
  if (solver.failure.empty()) cell.lines.emplace_back("not measured: taken as 0");
  return cell;
}

Cell frame_rate_cell(const std::optional<double>& rate) {
  Cell cell(rate ? number_text(*rate) : "—");
  cell.value = rate;
  return cell;
}

/// "10, 30, 125".
std::string frame_rates_text(const std::vector<double>& rates) {
  std::string out;
  for (const double rate : rates) out += (out.empty() ? "" : ", ") + number_text(rate);
  return out;
}

TableSection frame_rate_table(const std::vector<EnoughFrameRate>& answers, const std::string& noise,
                              std::span<const TrackingOfSolver> solvers,
                              std::optional<double> EnoughFrameRate::*by, const std::string& what,
                              const std::string& law) {
  TableSection table;
  table.caption = "Least frame rate (1/s) at which " + what + " by finger speed: " + noise + ", " +
                  law + " law";
  table.columns = {{"solver", Align::left}};
  for (const TrackingOfSolver& solver : solvers) {
    std::vector<Cell> row = {solver.label};
    for (const EnoughFrameRate& answer : answers) {
      if (answer.noise != noise || answer.label != solver.label) continue;
      if (table.rows.empty()) {
        table.columns.emplace_back(number_text(answer.speed_mm_s) + " mm/s (of " +
                                   frame_rates_text(answer.frame_rates) + ")");
      }
      row.push_back(frame_rate_cell(answer.*by));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

TableSection tracking_table(const TrackingCondition& condition, const std::string& law) {
  TableSection table;
  table.caption = condition.set + ": " + number_text(condition.speed_mm_s) + " mm/s, " +
                  number_text(condition.frame_rate) + " frames/s, " + condition.touch + ", " +
                  condition.noise + ", " + law + " law";
  table.columns = {{"solver", Align::left}, {"latency (ms)"}};
  for (const TrackingColumn& column : tracking_columns) {
    table.columns.emplace_back(column.title, Align::right, table.columns.size() < 6 ? 0 : 1);
  }
  for (const TrackingOfSolver& solver : condition.solvers) {
    Cell name = solver.label;
    if (!solver.failure.empty()) name.lines.push_back(solver.failure);
    std::vector<Cell> row = {name, tracking_latency_cell(solver)};
    for (const TrackingColumn& column : tracking_columns) {
      row.push_back(tracking_score_cell(solver, column));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law) {
  const std::vector<EnoughFrameRate> answers = enough_frame_rates(conditions);
  std::vector<std::string> noises;
  for (const EnoughFrameRate& answer : answers) {
    if (std::find(noises.begin(), noises.end(), answer.noise) == noises.end()) {
      noises.push_back(answer.noise);
    }
  }
  std::vector<TableSection> tables;
  for (const std::string& noise : noises) {
    const auto& solvers = conditions.front().solvers;
    tables.push_back(frame_rate_table(answers, noise, solvers, &EnoughFrameRate::for_reading,
                                      "characters are read back within 5 % of the best share,",
                                      law));
    tables.push_back(frame_rate_table(answers, noise, solvers, &EnoughFrameRate::for_the_place,
                                      "the RMS distance is within 5 % of the least,", law));
  }
  return tables;
}

TableSection tracking_data(std::span<const TrackingCondition> conditions, const std::string& law) {
  TableSection table;
  table.columns = {{"set", Align::left},
                   {"speed_mm_s"},
                   {"frame_rate"},
                   {"noise", Align::left},
                   {"law", Align::left},
                   {"solver", Align::left},
                   {"failure", Align::left},
                   {"latency_s"},
                   {"characters"},
                   {"with_rms"},
                   {"with_lag"},
                   {"with_frechet"}};
  for (const TrackingColumn& column : tracking_columns) {
    const std::string name = column.name;
    for (const char* end : {"", "_low", "_high"}) table.columns.emplace_back(name + end);
  }
  for (const TrackingCondition& condition : conditions) {
    for (const TrackingOfSolver& solver : condition.solvers) {
      std::vector<Cell> row = {condition.set,
                               exact_cell(condition.speed_mm_s),
                               exact_cell(condition.frame_rate),
                               condition.noise,
                               law,
                               solver.label,
                               solver.failure,
                               exact_cell(solver.latency_s),
                               std::to_string(solver.characters.size()),
                               std::to_string(solver.scores.with_rms),
                               std::to_string(solver.scores.with_lag),
                               std::to_string(solver.scores.with_frechet)};
      for (const TrackingColumn& column : tracking_columns) {
        const std::optional<Estimate>& score = solver.scores.*column.score;
        row.push_back(score ? exact_cell(score->value) : Cell());
        row.push_back(score ? exact_cell(score->ci95.low) : Cell());
        row.push_back(score ? exact_cell(score->ci95.high) : Cell());
      }
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace ertbench
