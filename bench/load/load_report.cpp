#include "bench/load/load_report.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/charts/method_styles.h"
#include "bench/plot/drawing.h"
#include "bench/plot/legend.h"
#include "bench/plot/panel.h"
#include "bench/record/provenance.h"
#include "bench/table/writers.h"
#include "core/atomic_file.h"
#include "core/json_text.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr double load_left = 66;
constexpr double load_top = 62;
constexpr double panel_width = 300;
constexpr double panel_height = 240;
constexpr double panel_gap = 24;
constexpr double legend_top = load_top + panel_height + 66;

std::string deadline_text(double seconds) { return number_text(1000 * seconds) + " ms"; }

/// Rates are whole frames where there are many; a star marks those that another run did not
/// confirm.
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
        canvas_(width(), legend_top + legend_height()) {}

  void draw(const std::filesystem::path& stem) {
    canvas_.title(results_.title + ": highest rate at which 99 % of the frames keep a deadline");
    for (const Arrivals arrivals : all_arrivals) draw_panel(arrivals);
    legend_.draw(canvas_, legend_top);
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
