#include "bench/studies/tracking.h"

#include <ranges>
#include <utility>

#include "bench/studies/columns.h"
#include "core/lists.h"
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
  out.latency_s = input.latency_s(label);
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

const char* const tracking_text =
    "A finger writes characters at constant speed. Frame n reaches the solver when its last drive "
    "is measured, and the result is out after the solver's own median latency; a frame that comes "
    "while it is busy waits, and is dropped when a newer one comes. The contacts go through one "
    "tracker, the same for all solvers, which confirms a track after two frames.\n\nRMS: the place "
    "known at a moment (that of the latest report) against the finger at the same moment, over 500 "
    "moments of each character while the finger is down. Lag: the delay that makes this RMS least, "
    "over the moments whose past of up to the longest lag looked at lies in strokes; RMS without "
    "lag: what then remains. Fréchet: the discrete Fréchet distance of the tracked path from the "
    "written one, stroke by stroke, of a character the largest; the places stand for the middles "
    "of their frames, so that delay does not count. Of these, means over the characters that have "
    "such a value; a cell says of how many where not all have.\n\nDrop-outs: of the frames worked "
    "on while the finger was down, those for which no place was reported. Dropped frames: of all, "
    "those that found the solver busy. False positives: confirmed tracks that a frame shows while "
    "nothing touches during it, or farther than 40 mm from the finger. Read back: characters whose "
    "tracked strokes, as they are when it is known when the finger is down, are nearest to the "
    "right one of 36 templates by dynamic time warping.";

using TrackingColumn = StudyColumn<TrackingOfSolver>;

/// `unit` names the value in summary.json. `characters`: how many have the value, where not all
/// need to.
TrackingColumn score_column(const std::string& key, std::optional<Estimate> TrackingScores::*score,
                            const char* unit, double factor,
                            int TrackingScores::*characters = nullptr) {
  return TrackingColumn::estimate(
             key, [score](const TrackingOfSolver& solver) { return solver.scores.*score; }, 1)
      .shown([=](const TrackingOfSolver& solver) {
        Cell cell = estimate_cell(scaled(solver.scores.*score, factor), 1);
        const int all = static_cast<int>(solver.characters.size());
        if (characters && solver.scores.*characters < all) {
          cell.lines.push_back("of " + std::to_string(solver.scores.*characters) + " of " +
                               std::to_string(all));
        }
        return cell;
      })
      .json([=](const TrackingOfSolver& solver) { return to_json(solver.scores.*score, unit); });
}

TrackingColumn count_column(const std::string& key, int TrackingScores::*count) {
  return TrackingColumn::count(
             key, [count](const TrackingOfSolver& solver) { return solver.scores.*count; })
      .data_only();
}

Cell latency_cell(const TrackingOfSolver& solver) {
  if (solver.latency_s) return number_cell(1000 * *solver.latency_s, 3);
  Cell cell = number_cell(std::nullopt, 3);
  if (solver.failure.empty()) cell.lines.emplace_back("not measured: taken as 0");
  return cell;
}

/// The columns of a test set, which the headlines name.
StudyColumns<TrackingOfSolver> tracking_columns(const std::string& set) {
  const auto headline = [set](const char* what) {
    return [text = set + ": " + what](const TrackingOfSolver&) { return text; };
  };
  return {
      TrackingColumn::number("latency_s", &TrackingOfSolver::latency_s, 3)
          .table("latency (ms)")
          .shown(latency_cell),
      TrackingColumn::count("characters",
                            [](const TrackingOfSolver& one) { return one.characters.size(); })
          .data_only(),
      count_column("with_rms", &TrackingScores::with_rms),
      count_column("with_lag", &TrackingScores::with_lag),
      count_column("with_frechet", &TrackingScores::with_frechet),
      score_column("rms_mm", &TrackingScores::rms_mm, "mean", 1, &TrackingScores::with_rms)
          .table("RMS (mm)")
          .headline(headline("RMS (mm)"), 2),
      score_column("rms_without_lag_mm", &TrackingScores::rms_without_lag_mm, "mean", 1,
                   &TrackingScores::with_lag)
          .table("RMS without lag (mm)"),
      score_column("lag_ms", &TrackingScores::lag_ms, "mean", 1, &TrackingScores::with_lag)
          .table("lag (ms)"),
      score_column("frechet_mm", &TrackingScores::frechet_mm, "mean", 1,
                   &TrackingScores::with_frechet)
          .table("Fréchet (mm)"),
      score_column("drop_outs", &TrackingScores::drop_outs, "share", 100).table("drop-outs (%)", 1),
      score_column("dropped_frames", &TrackingScores::dropped_frames, "share", 100)
          .table("dropped frames (%)", 1),
      score_column("ghosts", &TrackingScores::ghosts, "per_frame", 100)
          .table("false positives (in 100 frames)", 1),
      score_column("read_back", &TrackingScores::read_back, "share", 100)
          .table("read back (%)", 1)
          .headline(headline("read back (share)"), 3)};
}

json json_of(const TrackingCondition& condition) {
  const StudyColumns<TrackingOfSolver> columns = tracking_columns(condition.set);
  json out = {{"speed_mm_s", condition.speed_mm_s},
              {"frame_rate", condition.frame_rate},
              {"noise", condition.noise},
              {"touch", condition.touch}};
  for (const TrackingOfSolver& solver : condition.solvers) {
    json& one = out["solvers"][solver.label];
    if (!solver.failure.empty()) {
      one = {{"failure", solver.failure}, {"latency_s", to_json(solver.latency_s)}};
      continue;
    }
    one = columns.json(solver);
    one["characters"] = {{"all", solver.characters.size()},
                         {"with_rms", solver.scores.with_rms},
                         {"with_lag", solver.scores.with_lag},
                         {"with_frechet", solver.scores.with_frechet}};
  }
  return out;
}

json json_of(const EnoughFrameRate& answer) {
  return {{"solver", answer.label},
          {"speed_mm_s", answer.speed_mm_s},
          {"noise", answer.noise},
          {"frame_rates", answer.frame_rates},
          {"for_reading", to_json(answer.for_reading)},
          {"for_the_place", to_json(answer.for_the_place)}};
}

Cell frame_rate_cell(const std::optional<double>& rate) {
  Cell cell(rate ? number_text(*rate) : "—");
  cell.value = rate;
  return cell;
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
        const auto rates = std::views::transform(answer.frame_rates, number_text);
        table.columns.emplace_back(number_text(answer.speed_mm_s) + " mm/s (of " + joined(rates) +
                                   ")");
      }
      row.push_back(frame_rate_cell(answer.*by));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

TableSection tracking_table(const TrackingCondition& condition, const std::string& law) {
  const StudyColumns<TrackingOfSolver> columns = tracking_columns(condition.set);
  TableSection table;
  table.caption = condition.set + ": " + number_text(condition.speed_mm_s) + " mm/s, " +
                  number_text(condition.frame_rate) + " frames/s, " + condition.touch + ", " +
                  condition.noise + ", " + law + " law";
  table.columns = columns.titles({{"solver", Align::left}});
  for (const TrackingOfSolver& solver : condition.solvers) {
    Cell name = solver.label;
    if (!solver.failure.empty()) name.lines.push_back(solver.failure);
    table.rows.push_back(columns.cells({name}, solver));
  }
  return table;
}

std::vector<TableSection> frame_rate_tables(std::span<const TrackingCondition> conditions,
                                            const std::string& law) {
  const std::vector<EnoughFrameRate> answers = enough_frame_rates(conditions);
  std::vector<TableSection> tables;
  for (const std::string& noise : distinct(answers, &EnoughFrameRate::noise)) {
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
  for (const TrackingCondition& condition : conditions) {
    const StudyColumns<TrackingOfSolver> columns = tracking_columns(condition.set);
    table.columns = columns.names({{"set", Align::left},
                                   {"speed_mm_s"},
                                   {"frame_rate"},
                                   {"noise", Align::left},
                                   {"law", Align::left},
                                   {"solver", Align::left},
                                   {"failure", Align::left}});
    for (const TrackingOfSolver& solver : condition.solvers) {
      table.rows.push_back(columns.data(
          {condition.set, exact_cell(condition.speed_mm_s), exact_cell(condition.frame_rate),
           condition.noise, law, solver.label, solver.failure},
          solver));
    }
  }
  return table;
}

Study tracking_study(const StudyInput& input) {
  const std::string law = input.law();
  const auto conditions = std::make_shared<std::vector<TrackingCondition>>();
  for (const std::string& set : input.spec.sets) {
    conditions->push_back(tracking_condition(input, set));
  }

  Study study(input.spec.name, "Tracking (D.4)", {{"law", law}, {"conditions", json::object()}});
  StudySection& section = study.sections.front();
  section.subject = ": tracking";
  section.report.text = tracking_text;
  section.report.notes = {
      "Intervals: 95 %, by the bootstrap over characters; of the share read back Wilson's."};
  for (const TrackingCondition& condition : *conditions) {
    study.numbers["conditions"][condition.set] = json_of(condition);
    section.report.tables.push_back(tracking_table(condition, law));
    for (const TrackingOfSolver& solver : condition.solvers) {
      if (!solver.failure.empty()) continue;
      tracking_columns(condition.set).add_headlines(solver.label, solver, study.best);
    }
  }
  for (const EnoughFrameRate& answer : enough_frame_rates(*conditions)) {
    study.numbers["enough_frame_rates"].push_back(json_of(answer));
  }
  const std::vector<TableSection> rates = frame_rate_tables(*conditions, law);
  if (!rates.empty()) {
    section.report.tables.insert(section.report.tables.end(), rates.begin(), rates.end());
    section.report.notes.emplace_back(
        "Which frame rate is enough is said of the values as they were measured; the intervals of "
        "the tables by condition say whether they differ.");
  }
  section.figures = {tracking_figure(conditions, law)};
  section.data = {{"", tracking_data(*conditions, law)}};
  return study;
}

}  // namespace ertbench
