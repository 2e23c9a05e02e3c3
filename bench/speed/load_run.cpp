#include "bench/speed/load_run.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_solvers.h"
#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/record/cache.h"
#include "bench/record/record_file.h"
#include "bench/report/chart.h"
#include "bench/run/datasets.h"
#include "bench/speed/offered_load.h"
#include "bench/table/table.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

constexpr std::uint64_t most_frames_in_memory = 2000;
constexpr std::size_t service_frames = 1000;  ///< timed one by one before the search

json to_json(const KeptRate& rate, const char* arrivals, double deadline_s) {
  json out = {{"deadline_s", deadline_s},
              {"arrivals", arrivals},
              {"frames_per_s", nullptr},
              {"runs", rate.runs}};
  if (rate.per_s) {
    out.update({{"frames_per_s", *rate.per_s},
                {"p99_s", rate.p99_s},
                {"confirmed", rate.confirmed},
                {"confirmed_p99_s", rate.confirmed_p99_s},
                {"utilisation", rate.utilisation},
                {"frames", rate.frames}});
  }
  return out;
}

KeptRate kept_rate_from_json(const json& value) {
  KeptRate out;
  out.runs = value.at("runs").get<int>();
  if (value.at("frames_per_s").is_null()) return out;
  out.per_s = value.at("frames_per_s").get<double>();
  out.p99_s = value.at("p99_s").get<double>();
  out.confirmed = value.at("confirmed").get<bool>();
  out.confirmed_p99_s = value.at("confirmed_p99_s").get<double>();
  out.utilisation = value.at("utilisation").get<double>();
  out.frames = value.at("frames").get<std::size_t>();
  return out;
}

/// Runs in a child process. Calls of `progress` also show that the process does not hang.
SolverLoad measure(const Experiment& experiment, SolverEntry entry, const Cache& cache,
                   SolverRegistry& registry, const LoadOptions& options,
                   const std::function<void(const std::string&)>& progress) {
  registry.allow_plugins();
  describe(entry, registry.load(entry.type));
  const TemporaryFolder folder("load");
  const std::unique_ptr<Solver> solver =
      fitted_solver(fit_recipe(experiment, entry), cache, registry, options.threads,
                    folder / "progress")
          .solver;
  const DatasetFile set = cache.open_dataset(experiment.tests.front());
  const Frames voltages = set.voltages(0, std::min(set.size(), most_frames_in_memory));
  const Eigen::RowVectorXd reference = set.reference_voltages().transpose();
  TimedServer server(*solver, voltages, reference, experiment.sensor.pixels());

  SolverLoad out;
  out.label = entry.label;
  const std::vector<double> service_s = server.service_s(service_frames);
  out.service_p50_s = nearest_rank_quantile(service_s, 0.5);
  out.service_p99_s = nearest_rank_quantile(service_s, 0.99);
  out.service_mean_s =
      std::accumulate(service_s.begin(), service_s.end(), 0.0) / double(service_s.size());
  for (const double deadline_s : options.deadlines_s) {
    DeadlineRates rates;
    rates.deadline_s = deadline_s;
    for (const Arrivals arrivals : all_arrivals) {
      progress(number_text(1000 * deadline_s) + " ms, " + name_of(arrivals) + " arrivals");
      RateSearch search;
      search.arrivals = arrivals;
      search.deadline.seconds = deadline_s;
      search.least_frames = options.frames;
      search.seed = options.seed;
      (arrivals == Arrivals::fixed ? rates.fixed : rates.poisson) =
          highest_rate(search, service_s, server);
    }
    out.deadlines.push_back(rates);
  }
  out.lost_share = server.lost_share();
  return out;
}

SolverLoad measured_apart(const Experiment& experiment, const SolverEntry& entry,
                          const Cache& cache, SolverRegistry& registry,
                          const LoadOptions& options) {
  const IsolatedOutcome outcome = run_isolated(
      [&](const auto& send) {
        json said;
        try {
          said = to_json(
              measure(experiment, entry, cache, registry, options, [&](const std::string& what) {
                std::fprintf(stderr, "%s: %s\n", entry.label.c_str(), what.c_str());
                send("{}");
              }));
        } catch (const std::exception& exception) {
          said = {{"failure", exception.what()}};
        }
        send(json_text(said));
      },
      {experiment.time_limit_s, machine_memory_bytes() / 10 * 9}, StandardError::shared);
  SolverLoad failed;
  failed.label = entry.label;
  failed.failure = outcome.end.text();
  if (!outcome.finished || outcome.messages.empty()) return failed;
  const json said = parse_json(outcome.messages.back(), "what the solver's process said");
  failed.failure = said.value("failure", std::string());
  return failed.failure.empty() ? solver_load_from_json(said) : failed;
}

/// The first seed of each label asked for.
std::vector<const SolverEntry*> entries_of(const Experiment& experiment,
                                           const std::vector<std::string>& only) {
  std::vector<const SolverEntry*> out;
  std::set<std::string> labels;
  for (const SolverEntry& entry : experiment.solvers) {
    const bool wanted =
        only.empty() || std::find(only.begin(), only.end(), entry.label) != only.end();
    if (labels.insert(entry.label).second && wanted) out.push_back(&entry);
  }
  for (const std::string& label : only) {
    if (labels.contains(label)) continue;
    std::string known;
    for (const std::string& one : labels) known.append(known.empty() ? "" : ", ").append(one);
    throw InputError("--only: no solver is called \"" + printable(label) + "\"; there are " +
                     known);
  }
  return out;
}

}  // namespace

json to_json(const SolverLoad& load) {
  json out = {{"label", load.label},
              {"failure", load.failure},
              {"service_us",
               {{"p50", 1e6 * load.service_p50_s},
                {"p99", 1e6 * load.service_p99_s},
                {"mean", 1e6 * load.service_mean_s}}},
              {"lost_share", load.lost_share},
              {"rates", json::array()}};
  for (const DeadlineRates& rates : load.deadlines) {
    for (const Arrivals arrivals : all_arrivals) {
      out["rates"].push_back(to_json(rates.of(arrivals), name_of(arrivals), rates.deadline_s));
    }
  }
  return out;
}

SolverLoad solver_load_from_json(const json& value) {
  SolverLoad out;
  out.label = value.at("label").get<std::string>();
  out.failure = value.at("failure").get<std::string>();
  const json& service = value.at("service_us");
  out.service_p50_s = 1e-6 * service.at("p50").get<double>();
  out.service_p99_s = 1e-6 * service.at("p99").get<double>();
  out.service_mean_s = 1e-6 * service.at("mean").get<double>();
  out.lost_share = value.at("lost_share").get<double>();
  for (const json& rate : value.at("rates")) {
    const auto deadline_s = rate.at("deadline_s").get<double>();
    if (out.deadlines.empty() || out.deadlines.back().deadline_s != deadline_s) {
      out.deadlines.push_back({deadline_s, {}, {}});
    }
    DeadlineRates& rates = out.deadlines.back();
    (rate.at("arrivals") == "fixed" ? rates.fixed : rates.poisson) = kept_rate_from_json(rate);
  }
  return out;
}

LoadResults run_load(const Experiment& experiment, const Cache& cache, SolverRegistry& registry,
                     const LoadOptions& options) {
  LoadResults out;
  out.experiment = experiment.name;
  out.title = experiment.title;
  out.dataset = experiment.tests.front().name;
  out.deadlines_s = options.deadlines_s;
  out.frames = options.frames;
  out.seed = options.seed;
  const std::vector<const SolverEntry*> entries = entries_of(experiment, options.only);
  ensure_datasets(experiment, cache);
  for (const SolverEntry* entry : entries) {
    out.solvers.push_back(measured_apart(experiment, *entry, cache, registry, options));
    if (options.finished) options.finished(out);
  }
  return out;
}

namespace {

constexpr double load_left = 66;
constexpr double load_top = 62;
constexpr double panel_width = 300;
constexpr double panel_height = 240;
constexpr double panel_gap = 24;
constexpr double load_legend_top = load_top + panel_height + 66;

std::string deadline_text(double seconds) { return number_text(1000 * seconds) + " ms"; }

/// Large rates are rounded to whole frames; a star marks those that the second run did not confirm.
Cell rate_cell(const KeptRate& rate) {
  if (!rate.per_s) return {"–"};
  Cell cell(fixed(*rate.per_s, *rate.per_s < 10 ? 1 : 0) + (rate.confirmed ? "" : "*"));
  cell.value = *rate.per_s;
  return cell;
}

/// Two panels and a legend.
class LoadFigure {
 public:
  explicit LoadFigure(const LoadResults& results)
      : results_(results),
        styles_(styles_of(results.solvers)),
        legend_(load_left, width() - 10),
        canvas_(width(), load_legend_top + legend_height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.title(results_.title + ": highest rate at which 99 % of the frames keep a deadline");
    for (const Arrivals arrivals : all_arrivals) draw_panel(arrivals);
    legend_.draw(canvas_, load_legend_top);
    canvas_.draw(stem);
  }

 private:
  static double width() { return load_left + 2 * (panel_width + panel_gap); }

  static bool keeps_any(const SolverLoad& solver) {
    return std::any_of(solver.deadlines.begin(), solver.deadlines.end(),
                       [](const auto& rates) { return rates.fixed.per_s || rates.poisson.per_s; });
  }

  double legend_height() {
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const SolverLoad& solver = results_.solvers[s];
      if (keeps_any(solver))
        legend_.add({solver.label, styles_.line(s, 1.4), styles_.mark(s, 0.85)});
    }
    for (const SolverLoad& solver : results_.solvers) {
      if (keeps_any(solver)) continue;
      legend_.new_line();
      legend_.add({solver.label + (solver.failure.empty() ? ": keeps none of the deadlines"
                                                          : " ✕ " + one_line(solver.failure, 60))});
    }
    if (std::any_of(results_.solvers.begin(), results_.solvers.end(),
                    [](const SolverLoad& solver) { return solver.busy(); })) {
      legend_.new_line();
      legend_.add({"The machine was busy with something else: these rates are too low."});
    }
    return legend_.height();
  }

  Axis rate_axis() const {
    Span span;
    for (const SolverLoad& solver : results_.solvers) {
      for (const DeadlineRates& rates : solver.deadlines) {
        for (const Arrivals arrivals : all_arrivals) {
          if (rates.of(arrivals).per_s) span.extend(*rates.of(arrivals).per_s);
        }
      }
    }
    if (span.empty()) span = {1, 1000};
    return Axis::logarithms({span.low / 1.6, span.high * 1.6}, "highest rate, frames/s");
  }

  Axis deadline_axis() const {
    const auto [least, most] =
        std::minmax_element(results_.deadlines_s.begin(), results_.deadlines_s.end());
    Axis axis{*least / 1.5, *most * 1.5, true};
    for (const double deadline_s : results_.deadlines_s) {
      axis.ticks.push_back({deadline_s, deadline_text(deadline_s)});
    }
    axis.title = "deadline of 99 % of the frames, from arrival to image";
    return axis;
  }

  void draw_panel(Arrivals arrivals) {
    const double left = load_left + (arrivals == Arrivals::fixed ? 0 : panel_width + panel_gap);
    Axis upright = rate_axis();
    if (arrivals == Arrivals::poisson) {
      upright.title.clear();
      for (Tick& tick : upright.ticks) tick.text.clear();
    }
    Panel panel(canvas_, Box::sized(left, load_top, panel_width, panel_height), deadline_axis(),
                upright);
    panel.title(arrivals == Arrivals::fixed ? "arrivals at a fixed rate" : "Poisson arrivals");
    for (std::size_t s = 0; s < results_.solvers.size(); ++s) {
      const SolverLoad& solver = results_.solvers[s];
      Points points;
      for (const DeadlineRates& rates : solver.deadlines) {
        const KeptRate& rate = rates.of(arrivals);
        if (!rate.per_s) continue;
        points.emplace_back(rates.deadline_s, *rate.per_s);
        std::string text = solver.label + ", " + deadline_text(rates.deadline_s);
        text.append("\n").append(fixed(*rate.per_s, 0)).append(" frames/s, busy for ");
        text.append(fixed(100 * rate.utilisation, 0)).append(" % of the time, p99 ");
        text.append(three_digits(1000 * rate.p99_s)).append(" ms");
        panel.tooltip(rates.deadline_s, *rate.per_s, text);
      }
      panel.line(points, styles_.line(s, 1.4));
      panel.marks(points, styles_.mark(s, 0.85));
    }
    panel.draw();
  }

  const LoadResults& results_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
};

nlohmann::json load_json(const LoadResults& results) {
  nlohmann::json out = {
      {"schema", 2},
      {"provenance", machine_provenance()},
      {"note",
       "frames_per_s is the highest rate at which the share of the frames was finished within the "
       "deadline of its arrival, in a run of so many frames; confirmed says whether another run of "
       "the same rate with other arrivals did so too, with the latency that it had. One thread. "
       "lost_share is the part of the time in which the machine did something else."},
      {"experiment", results.experiment},
      {"dataset", results.dataset},
      {"share", LoadDeadline{}.share},
      {"least_frames", results.frames},
      {"least_deadlines", RateSearch{}.least_deadlines},
      {"resolution", RateSearch{}.resolution},
      {"seed", results.seed},
      {"deadlines_s", results.deadlines_s},
      {"rows", nlohmann::json::array()}};
  for (const SolverLoad& solver : results.solvers) out["rows"].push_back(to_json(solver));
  return out;
}

}  // namespace

Table load_table(const LoadResults& results) {
  Table table;
  table.title = results.title + ": highest rates";
  table.text =
      "Frames a second at which 99 % of the frames are finished within a deadline of their "
      "arrival, those that had to wait included; one thread.";
  TableSection section;
  section.columns = {Column("solver", Align::left), "p50, ms", "p99, ms"};
  for (const double deadline_s : results.deadlines_s) {
    section.columns.emplace_back(deadline_text(deadline_s) + ", fixed");
    section.columns.emplace_back(deadline_text(deadline_s) + ", Poisson");
  }
  bool unconfirmed = false;
  bool busy = false;
  for (const SolverLoad& solver : results.solvers) {
    std::vector<Cell> row = {solver.label};
    if (!solver.failure.empty()) {
      row[0].lines = {solver.failure};
      row.resize(section.columns.size(), Cell("–"));
      section.rows.push_back(std::move(row));
      continue;
    }
    if (solver.busy()) {
      busy = true;
      row[0].lines = {"machine busy: " + fixed(100 * solver.lost_share, 0) + " % of the time lost"};
    }
    for (const double seconds : {solver.service_p50_s, solver.service_p99_s}) {
      row.emplace_back(three_digits(1000 * seconds));
      row.back().value = 1000 * seconds;
    }
    for (const DeadlineRates& rates : solver.deadlines) {
      for (const Arrivals arrivals : all_arrivals) {
        row.push_back(rate_cell(rates.of(arrivals)));
        unconfirmed |= row.back().text.ends_with('*');
      }
    }
    section.rows.push_back(std::move(row));
  }
  section.notes = {"p50 and p99: of a frame that does not wait. – : no rate keeps the deadline."};
  if (unconfirmed) {
    section.notes.emplace_back(
        "* A second run at this rate, with other arrivals, missed the "
        "deadline: the rate is at the edge, or the machine was disturbed.");
  }
  if (busy) {
    section.notes.emplace_back(
        "The machine was busy with something else: rates are lower than an "
        "idle machine keeps. Measure again before you compare.");
  }
  table.sections.push_back(std::move(section));
  return table;
}

bool draw_load(const LoadResults& results, const std::filesystem::path& stem) {
  return draw_or_say(stem, [&] { LoadFigure(results).draw(stem); });
}

bool write_load(const LoadResults& results, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const Table table = load_table(results);
  write_file_atomically(folder / "load.json", json_text(load_json(results), 1) + "\n");
  write_file_atomically(folder / "load.md", markdown_of(table));
  write_file_atomically(folder / "load.csv", csv_of(table.sections.front()));
  return draw_load(results, folder / "load");
}

}  // namespace ertbench
