#include "bench/publish/latency_pairs.h"

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/publish/published_folder.h"
#include "core/json.h"
#include "core/statistics.h"
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

/// Whether what a frame costs depends on what is in it.
bool work_follows_frame(const ResultRow& row) {
  const json& settings = *row.parameters;
  const bool iterates = settings.contains("tolerance");
  const bool adds_contacts = settings.contains("most_contacts");
  const bool is_mixture = settings.value("components", 1) > 1;
  return iterates || adds_contacts || is_mixture;
}

/// By how much two intervals may miss each other: the range of three or five rounds is not that of
/// all there could be.
constexpr double miss = 0.01;

bool meet(const Interval& a, const Interval& b) {
  return a.low <= (1 + miss) * b.high && b.low <= (1 + miss) * a.high;
}

Interval range(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return {*least, *most};
}

LatencyPair pair_of(const TimedSolver& a, const TimedSolver& b) {
  LatencyPair pair{a, b, false, ""};
  const bool units = !a.rounds_in_units.empty() && !b.rounds_in_units.empty();
  pair.agree = meet(range(a.rounds_us), range(b.rounds_us)) ||
               (units && meet(range(a.rounds_in_units), range(b.rounds_in_units)));
  if (pair.agree) return pair;
  if (!a.says_build || !b.says_build) {
    pair.reason = "made before results said which build timed them: " + a.build + "; " + b.build;
  } else if (a.cpu != b.cpu) {
    pair.reason = "other machines: " + a.cpu + "; " + b.cpu;
  } else if (!a.system.empty() && !b.system.empty() && a.system != b.system) {
    pair.reason = "other machines of one name, " + a.cpu + ": " + a.system + "; " + b.system;
  } else if (a.build != b.build) {
    pair.reason = "other builds: " + a.build + "; " + b.build;
  }
  return pair;
}

std::string time_text(const TimedSolver& solver) {
  const Interval interval = latency_interval(solver);
  return three_digits(median(solver.rounds_us)) + " [" + three_digits(interval.low) + ", " +
         three_digits(interval.high) + "]";
}

}  // namespace

Interval latency_interval(const TimedSolver& solver) { return range(solver.rounds_us); }

std::string timed_settings(const ResultRow& row, const json& test_sets) {
  json settings = *row.parameters;
  for (const char* name : training_settings) settings.erase(name);
  if (work_follows_frame(row)) {
    settings["frames"] = {row.frames, test_sets.value(row.dataset, json(row.dataset))};
  } else {
    // Weights of priors and losses: what is fitted with them is applied at the same cost.
    for (auto it = settings.begin(); it != settings.end();) {
      it = it->is_number_float() ? settings.erase(it) : std::next(it);
    }
  }
  settings.erase("contacts");  // are read out of the finished image
  // A frame has as many voltages as the electrodes give, and an image its pixels.
  const json sensor = test_sets.value(row.dataset, json::object()).value("sensor", json::object());
  for (const char* size : {"electrode_count", "image_grid"}) {
    if (sensor.contains(size)) settings["sensor"][size] = sensor.at(size);
  }
  settings["type"] = row.type;
  return settings.dump();
}

std::vector<TimedSolver> timed_solvers(const std::string& result, const json& provenance,
                                       const std::vector<ResultRow>& rows) {
  const json test_sets = provenance.value("datasets", json::object());
  std::vector<TimedSolver> out;
  std::vector<bool> has_units;
  for (const ResultRow& row : rows) {
    if (!row.latency_us) continue;
    TimedSolver timed{result,
                      row.label,
                      timed_settings(row, test_sets),
                      {},
                      {},
                      row.timed_on && !row.timed_on->cpu.empty()
                          ? row.timed_on->cpu
                          : provenance.value("cpu", "unknown"),
                      "commit " + provenance.value("commit", "unknown")};
    if (!row.build.timed.empty()) {
      const BuildStamp& build = row.build.timed.front();
      timed.build = "commit " + build.commit_text() + ", program " + build.program.substr(0, 8);
      timed.says_build = true;
    }
    if (timed.cpu == provenance.value("cpu", "unknown")) {
      timed.system = provenance.value("system", "");
    }
    auto found = std::find_if(out.begin(), out.end(), [&](const TimedSolver& other) {
      return other.settings == timed.settings && other.build == timed.build;
    });
    if (found == out.end()) {
      out.push_back(std::move(timed));
      has_units.push_back(true);
      found = std::prev(out.end());
    }
    std::vector<double> rounds = row.latency_us->p50_of_rounds;
    if (rounds.empty()) rounds = {row.latency_us->p50};
    found->rounds_us.insert(found->rounds_us.end(), rounds.begin(), rounds.end());
    std::vector<double> units = row.latency_us->relative_of_rounds;
    if (units.empty() && row.calibration_us) {
      for (const double round : rounds) units.push_back(round / *row.calibration_us);
    }
    found->rounds_in_units.insert(found->rounds_in_units.end(), units.begin(), units.end());
    if (units.empty()) has_units[static_cast<std::size_t>(found - out.begin())] = false;
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!has_units[i]) out[i].rounds_in_units.clear();
  }
  return out;
}

std::vector<TimedSolver> timed_solvers(const fs::path& published) {
  std::vector<TimedSolver> out;
  for (const fs::path& folder : published_folders(published)) {
    const fs::path file = folder / "summary.json";
    if (!fs::exists(file)) continue;
    const json summary = read_json_file(file);
    json provenance = summary.at("provenance");
    // The machine of the times is not always that of the result.
    if (summary.contains("clocks")) {
      provenance["system"] = summary.at("clocks").value("system", "");
    }
    JsonObject root(summary, file.string(), "");
    std::vector<ResultRow> rows;
    for (const JsonObject& object : root.objects("rows")) {
      rows.push_back(result_row_from_json(object));
    }
    for (TimedSolver& timed : timed_solvers(folder.filename().string(), provenance, rows)) {
      out.push_back(std::move(timed));
    }
  }
  return out;
}

std::vector<LatencyPair> latency_pairs(const std::vector<TimedSolver>& solvers) {
  std::map<std::string, std::vector<const TimedSolver*>> alike;
  for (const TimedSolver& solver : solvers) alike[solver.settings].push_back(&solver);
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
      "one frame, one thread, in rounds that all solvers of an experiment share. Here is each pair "
      "of "
      "results that time a solver with the same settings: the median of p50 over the rounds of all "
      "their test sets, since what a frame costs does not depend on the set, and the interval from "
      "the least to the greatest. Solvers whose work is as much as a frame asks for (they iterate, "
      "add contacts or leave out components that weigh nothing) are paired where the test sets are "
      "the same as well. Two agree where these meet or miss each other by less than a hundredth, "
      "in µs or in units of the calibration loop "
      "that runs beside each round. A machine is known by the name of its processor, which may "
      "stand "
      "for several generations (\"AMD EPYC\"): they can differ in how wide their vector units are, "
      "by "
      "which networks run at other times while the loop does not.";
  TableSection& section = table.sections.emplace_back();
  section.columns = {{"solver", Align::left},    {"in", Align::left},
                     {"p50 (µs)", Align::right}, {"and in", Align::left},
                     {"p50 (µs)", Align::right}, {"", Align::left}};
  for (const LatencyPair& pair : pairs) {
    section.rows.push_back({pair.first.label, pair.first.result, time_text(pair.first),
                            pair.second.result, time_text(pair.second),
                            pair.agree            ? "agree"
                            : pair.reason.empty() ? "differ, for no reason that is known"
                                                  : "differ; " + pair.reason});
  }
  return table;
}

}  // namespace ertbench
