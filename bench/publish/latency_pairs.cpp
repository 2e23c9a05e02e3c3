#include "bench/publish/latency_pairs.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "core/json_reader.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Settings that say how a network is trained and have no say in what a frame costs.
constexpr std::array training_settings = {
    "training",  "seed",          "chosen",          "epochs",      "batch",       "patience",
    "schedule",  "symmetries",    "new_scenes",      "precision",   "loss",        "train_dense",
    "slow_rate", "learning_rate", "training_faults", "fault_share", "content_loss"};

bool meet(const Interval& a, const Interval& b) { return a.low <= b.high && b.low <= a.high; }

Interval in_units(const Interval& us, const std::optional<double>& unit) {
  return unit ? Interval{us.low / *unit, us.high / *unit} : us;
}

LatencyPair pair_of(const TimedRow& a, const TimedRow& b) {
  LatencyPair pair{a, b, false, ""};
  const Interval first = latency_interval(a.row);
  const Interval second = latency_interval(b.row);
  const bool units = a.row.calibration_us && b.row.calibration_us;
  pair.agree = meet(first, second) || (units && meet(in_units(first, a.row.calibration_us),
                                                     in_units(second, b.row.calibration_us)));
  if (pair.agree) return pair;
  if (a.row.build.timed.empty() || b.row.build.timed.empty()) {
    pair.reason = "made before results said which build timed them: " + a.build + "; " + b.build;
  } else if (a.cpu != b.cpu) {
    pair.reason = "other machines: " + a.cpu + "; " + b.cpu;
  } else if (a.build != b.build) {
    pair.reason = "other builds: " + a.build + "; " + b.build;
  }
  return pair;
}

std::string time_text(const ResultRow& row) {
  const Interval interval = latency_interval(row);
  return three_digits(row.latency_us->p50) + " [" + three_digits(interval.low) + ", " +
         three_digits(interval.high) + "]";
}

}  // namespace

Interval latency_interval(const ResultRow& row) {
  const std::vector<double>& rounds = row.latency_us->p50_of_rounds;
  if (rounds.empty()) return {row.latency_us->p50, row.latency_us->p50};
  const auto [least, most] = std::minmax_element(rounds.begin(), rounds.end());
  return {*least, *most};
}

std::string timed_settings(const ResultRow& row) {
  json settings = *row.parameters;
  for (const char* name : training_settings) settings.erase(name);
  settings.erase("contacts");  // are read out of the finished image
  if (settings.contains("tolerance")) {
    settings["dataset"] = row.dataset;
    settings["frames"] = row.frames;
  } else {
    // Weights of priors and losses: what is fitted with them is applied at the same cost.
    for (auto it = settings.begin(); it != settings.end();) {
      it = it->is_number_float() ? settings.erase(it) : std::next(it);
    }
  }
  settings["type"] = row.type;
  return settings.dump();
}

std::vector<TimedRow> timed_rows(const fs::path& published) {
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(published)) {
    if (fs::exists(entry.path() / "summary.json")) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end());
  std::vector<TimedRow> out;
  for (const fs::path& folder : folders) {
    const fs::path file = folder / "summary.json";
    const json summary = read_json_file(file);
    const json& provenance = summary.at("provenance");
    JsonObject root(summary, file.string(), "");
    for (const JsonObject& object : root.objects("rows")) {
      TimedRow timed{folder.filename().string(), result_row_from_json(object),
                     provenance.value("cpu", "unknown"), ""};
      if (!timed.row.latency_us) continue;
      timed.build = "commit " + provenance.value("commit", "unknown");
      if (!timed.row.build.timed.empty()) {
        const BuildStamp& build = timed.row.build.timed.front();
        timed.build = "commit " + build.commit_text() + ", program " + build.program.substr(0, 8);
      }
      out.push_back(std::move(timed));
    }
  }
  return out;
}

std::vector<LatencyPair> latency_pairs(const std::vector<TimedRow>& rows) {
  std::map<std::string, std::vector<const TimedRow*>> alike;
  for (const TimedRow& row : rows) alike[timed_settings(row.row)].push_back(&row);
  std::vector<LatencyPair> out;
  for (const auto& [settings, group] : alike) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      for (std::size_t j = i + 1; j < group.size(); ++j) {
        if (group[i]->result == group[j]->result) continue;
        out.push_back(pair_of(*group[i], *group[j]));
      }
    }
  }
  return out;
}

Table latency_table(const std::vector<LatencyPair>& pairs) {
  Table table;
  table.title = "Times that several results have of one solver";
  table.text =
      "Every latency in a table comes from the same stage: raw voltages to the finished image of "
      "one "
      "frame, one thread, in rounds that all solvers of an experiment share. Here is each pair of "
      "results that time a solver with the same settings. Intervals: the least and the greatest "
      "p50 "
      "of the rounds. Two agree where these meet, in µs or in units of the calibration loop that "
      "each process runs beside them.";
  TableSection& section = table.sections.emplace_back();
  section.columns = {{"solver", Align::left},    {"in", Align::left},
                     {"p50 (µs)", Align::right}, {"and in", Align::left},
                     {"p50 (µs)", Align::right}, {"", Align::left}};
  for (const LatencyPair& pair : pairs) {
    section.rows.push_back({pair.first.row.label, pair.first.result, time_text(pair.first.row),
                            pair.second.result, time_text(pair.second.row),
                            pair.agree            ? "agree"
                            : pair.reason.empty() ? "differ, for no reason that is known"
                                                  : "differ; " + pair.reason});
  }
  return table;
}

}  // namespace ertbench
