#include "bench/studies/tracking.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/report/report.h"
#include "bench/studies/study.h"
#include "bench/studies/tracking_figure.h"
#include "bench/table/table.h"
#include "core/files.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// The frames of one sequence as the solver gets them. `readings` of the whole set.
std::vector<StreamFrame> stream_of(const DatasetSpec& spec, std::uint64_t sequence,
                                   const std::vector<FrameReading>& readings) {
  const SequenceSet& set = *spec.sequences();
  const Sheet& sheet = *spec.sensor.sheet;
  const Eigen::Vector2d centre_mm = sheet.unit_mm() * sheet.bounds().center();
  std::vector<StreamFrame> frames;
  for (std::uint64_t n = 0; n < set.frames_of(sequence); ++n) {
    const auto number = static_cast<double>(n);
    StreamFrame frame{
        set.timing().middle_s(number, spec.sensor.drives()), set.timing().end_s(number), {}};
    for (const ContactReading& contact : readings[set.first_frame(sequence) + n].contacts) {
      frame.contacts_mm.push_back(contact.place_mm - centre_mm);
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

TrackingOfSolver tracking_of_solver(const StudyInput& input, const TrackingCondition& condition,
                                    const std::string& label) {
  const DatasetSpec& spec = input.set_spec(condition.set);
  const SequenceSet& set = *spec.sequences();
  TrackingOfSolver out;
  out.label = label;
  if (const auto latency = input.latency(label)) out.latency_s = latency->p50_s;
  const std::vector<FrameReading>* readings = input.readings(label, condition.set);
  if (!readings || readings->size() < set.frames()) {
    out.failure = input.failure(label);
    if (out.failure.empty()) out.failure = "no contacts were kept of this set";
    return out;
  }
  const CharacterReader reader(condition.size_mm);
  for (std::uint64_t sequence = 0; sequence < set.sequences(); ++sequence) {
    RandomStream random = spec.stream(sequence, Purpose::scene);
    out.characters.push_back(track_character(set.draw(sequence, random, spec.sensor),
                                             stream_of(spec, sequence, *readings),
                                             out.latency_s.value_or(0), reader));
  }
  out.scores = tracking_scores(out.characters, condition.set + " " + label);
  return out;
}

TrackingCondition tracking_condition(const StudyInput& input, const std::string& set) {
  const DatasetSpec& spec = input.set_spec(set);
  const auto& plan = std::get<WritePlan>(spec.sequences()->plan());
  TrackingCondition out;
  out.set = set;
  out.speed_mm_s = plan.speed_mm_s;
  out.frame_rate = spec.sequences()->timing().frame_rate;
  out.size_mm = plan.size_mm;
  out.touch = plan.indenter.text() + ", " + force_text({plan.force_N, plan.force_N});
  out.noise = noise_text(spec.noise);
  for (const std::string& label : input.labels()) {
    out.solvers.push_back(tracking_of_solver(input, out, label));
  }
  return out;
}

json json_of_score(const std::optional<Estimate>& score, const char* name) {
  if (!score) return nullptr;
  return {{name, score->value}, {"ci95", {score->ci95.low, score->ci95.high}}};
}

json json_of_tracking(const TrackingOfSolver& solver) {
  json out = {{"latency_s", solver.latency_s ? json(*solver.latency_s) : json()}};
  if (!solver.failure.empty()) {
    out["failure"] = solver.failure;
    return out;
  }
  const TrackingScores& scores = solver.scores;
  out["rms_mm"] = json_of_score(scores.rms_mm, "mean");
  out["rms_without_lag_mm"] = json_of_score(scores.rms_without_lag_mm, "mean");
  out["lag_ms"] = json_of_score(scores.lag_ms, "mean");
  out["frechet_mm"] = json_of_score(scores.frechet_mm, "mean");
  out["drop_outs"] = json_of_score(scores.drop_outs, "share");
  out["dropped_frames"] = json_of_score(scores.dropped_frames, "share");
  out["ghosts"] = json_of_score(scores.ghosts, "per_frame");
  out["read_back"] = json_of_score(scores.read_back, "share");
  out["characters"] = {{"all", solver.characters.size()},
                       {"with_rms", scores.with_rms},
                       {"with_lag", scores.with_lag},
                       {"with_frechet", scores.with_frechet}};
  return out;
}

const char* const tracking_text =
    "A finger writes characters at constant speed. Frame n reaches the solver when its last drive "
    "is measured, and the result is out after the solver's own median latency; a frame that comes "
    "while it is busy waits, and is dropped when a newer one comes. The contacts go through one "
    "tracker, the same for all solvers, which confirms a track after two frames.\n\n"
    "RMS: the place known at a moment (that of the latest report) against the finger at the same "
    "moment, over 500 moments of each character while the finger is down. Lag: the delay that "
    "makes this RMS least, over the moments whose past of up to the longest lag looked at lies in "
    "strokes; RMS without lag: what then remains. Fréchet: the discrete Fréchet distance of the "
    "tracked path from the written one, stroke by stroke, of a character the largest; the places "
    "stand for the middles of their frames, so that delay does not count. Of these, means over the "
    "characters that have such a value; a cell says of how many where not all have.\n\n"
    "Drop-outs: of the frames worked on while the finger was down, those for which no place was "
    "reported. Dropped frames: of all, those that found the solver busy. Ghosts: confirmed tracks "
    "that a frame shows while nothing touches during it, or farther than 40 mm from the finger. "
    "Read back: characters whose tracked strokes, as they are when it is known when the finger is "
    "down, are nearest to the right one of 36 templates by dynamic time warping.";

}  // namespace

Tracking::Tracking(const StudyInput& input) : name_(input.spec.name), law_(input.law()) {
  for (const std::string& set : input.spec.sets) {
    conditions_.push_back(tracking_condition(input, set));
  }
}

json Tracking::summary() const {
  json out = {{"law", law_}, {"conditions", json::object()}};
  for (const TrackingCondition& condition : conditions_) {
    json& one = out["conditions"][condition.set];
    one = {{"speed_mm_s", condition.speed_mm_s},
           {"frame_rate", condition.frame_rate},
           {"noise", condition.noise},
           {"touch", condition.touch}};
    for (const TrackingOfSolver& solver : condition.solvers) {
      one["solvers"][solver.label] = json_of_tracking(solver);
    }
  }
  for (const EnoughFrameRate& answer : enough_frame_rates(conditions_)) {
    out["enough_frame_rates"].push_back(
        {{"solver", answer.label},
         {"speed_mm_s", answer.speed_mm_s},
         {"noise", answer.noise},
         {"frame_rates", answer.frame_rates},
         {"for_reading", answer.for_reading ? json(*answer.for_reading) : json()},
         {"for_the_place", answer.for_the_place ? json(*answer.for_the_place) : json()}});
  }
  return out;
}

std::vector<Headline> Tracking::headlines() const {
  std::vector<Headline> out;
  for (const TrackingCondition& condition : conditions_) {
    for (const TrackingOfSolver& solver : condition.solvers) {
      if (!solver.failure.empty()) continue;
      const TrackingScores& scores = solver.scores;
      out.push_back({solver.label, condition.set + ": RMS (mm)", 2, value_of(scores.rms_mm)});
      out.push_back(
          {solver.label, condition.set + ": read back (share)", 3, value_of(scores.read_back)});
    }
  }
  return out;
}

std::vector<ReportSection> Tracking::report(const std::string& title,
                                            const std::filesystem::path& folder) const {
  ReportSection section;
  section.title = "Tracking (D.4)";
  section.text = tracking_text;
  const std::string heading = without_law(title);
  section.figures = {
      tracking_sweep(conditions_, law_, heading, folder / name_),
      tracking_gallery(conditions_.front(), law_, heading, folder / (name_ + "_characters"))};
  section.notes = {
      "Intervals: 95 %, by the bootstrap over characters; of the share read back Wilson's."};
  for (const TrackingCondition& condition : conditions_) {
    section.tables.push_back(tracking_table(condition, law_));
  }
  const std::vector<TableSection> rates = frame_rate_tables(conditions_, law_);
  if (!rates.empty()) {
    section.tables.insert(section.tables.end(), rates.begin(), rates.end());
    section.notes.emplace_back(
        "Which frame rate is enough is said of the values as they were measured; the intervals of "
        "the tables by condition say how far they can be told apart.");
  }
  Table table;
  table.title = title + ": tracking";
  table.text = tracking_text;
  table.sections = section.tables;
  table.legend = section.notes;
  write_file_atomically(folder / (name_ + ".md"), markdown_of(table));
  write_file_atomically(folder / (name_ + ".csv"), csv_of(tracking_data(conditions_, law_)));
  return {section};
}

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
