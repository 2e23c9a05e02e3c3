#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "bench/fidelity/fidelity.h"
#include "bench/plot/canvas.h"
#include "bench/plot/panel.h"
#include "bench/record/record_file.h"
#include "bench/speed/speed_accuracy.h"
#include "bench/table/table.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

// Places and sizes in px.
constexpr int panel_width = 290;
constexpr int panel_height = 250;
constexpr int left_margin = 70;
constexpr int gap = 34;
constexpr int top = 62;
constexpr int to_bars = panel_height + 62;  ///< from a panel's top
constexpr int bar_height = 22;
constexpr int row_height = to_bars + 3 * bar_height + 40;
constexpr int most_across = 2;  ///< so that a page need not scale the text down
constexpr int notes_height = 100;

constexpr LineStyle whisker_line{rgb(0x909090), 1};

bool automatic(const FidelityRow& row) { return row.model == "auto"; }

std::vector<const FidelityRow*> rows_of(const std::vector<FidelityRow>& rows,
                                        const std::string& dataset, const std::string& scenes) {
  std::vector<const FidelityRow*> out;
  for (const FidelityRow& row : rows) {
    if (row.dataset == dataset && row.scenes == scenes) out.push_back(&row);
  }
  return out;
}

/// The models of one dataset, by time and error.
void plot_models(Canvas& canvas, const std::vector<FidelityRow>& rows, const std::string& dataset,
                 const Box& box, const Axis& times, const Axis& errors) {
  Panel panel(canvas, box, times, errors);
  panel.title(dataset);
  Points grids;
  Points autos;
  std::vector<Whisker> up;
  std::vector<Whisker> across;
  std::vector<PointLabel> labels;
  std::vector<Box> taken;
  double bound = 0.25;
  for (const FidelityRow* row : rows_of(rows, dataset, "all")) {
    bound = row->bound;
    const double error = errors.capped(row->error_median);
    (automatic(*row) ? autos : grids).emplace_back(row->time_us, error);
    up.push_back({row->time_us, error, row->error_max});
    across.push_back({error, row->time_low, row->time_high});
    const double x = panel.x(row->time_us);
    const double y = panel.y(error);
    labels.push_back({row->model, x, y});
    taken.push_back({x - 4, panel.y(row->error_max), x + 4, y + 4});
    taken.push_back({panel.x(row->time_low), y - 3, panel.x(row->time_high), y + 3});
    canvas.tooltip_at(x, y,
                      row->model + (automatic(*row) ? "" : " grid") + "\n" +
                          time_text(row->time_us) + " a scene\nerror: median " +
                          three_digits(row->error_median) + ", 95 % " +
                          three_digits(row->error_p95) + ", largest " +
                          three_digits(row->error_max) + " of the noise");
  }
  panel.level(bound, {ink::dark, 1.2, 2});
  panel.line(grids, {hue(0).towards_white(0.5), 1.2});
  panel.whiskers(up, whisker_line);
  panel.whiskers_across(across, whisker_line);
  panel.marks(grids, {filled(1), hue(0)});
  panel.marks(autos, {filled(0), hue(1), 1.1});
  panel.draw();
  const double promised = panel.y(bound);
  taken.push_back({panel.x(times.low), promised - 2, panel.x(times.high), promised + 2});
  std::vector<Segment> lines;
  for (std::size_t i = 1; i < grids.size(); ++i) {
    lines.push_back({panel.x(grids[i - 1].first), panel.y(grids[i - 1].second),
                     panel.x(grids[i].first), panel.y(grids[i].second)});
  }
  panel.labels(labels, taken, lines);
}

Colour shade(std::size_t size) {
  return viridis(1 - static_cast<double>(size) / static_cast<double>(std::size(fidelity_sizes)));
}

/// Stacked bars of the shares of scenes by number of points.
void draw_sizes(Canvas& canvas, const std::vector<FidelityRow>& rows, const std::string& dataset,
                double left, double y) {
  for (const char* scenes : {"smooth", "other", "all"}) {
    for (const FidelityRow* row : rows_of(rows, dataset, scenes)) {
      if (row->sizes.empty()) continue;
      canvas.text(row->scenes, left + 40, y + bar_height / 2.0 - 2,
                  {.size = 9, .align = TextAlign::right});
      const Box box = Box::sized(left + 46, y, panel_width - 46, bar_height - 5);
      double before = 0;
      for (std::size_t s = 0; s < row->sizes.size(); ++s) {
        const double share = static_cast<double>(row->sizes[s]) / row->count;
        if (share <= 0) continue;
        const Box part{box.across(before), box.top, box.across(before + share), box.bottom};
        before += share;
        canvas.rectangle(part, {.fill = shade(s)});
        if (part.width() <= 22) continue;
        canvas.text(fixed(100 * share, 0) + " %", part.middle(), part.centre(),
                    {.size = 8, .colour = shade(s).lightness() > 0.55 ? ink::black : ink::white});
      }
      y += bar_height;
    }
  }
}

void draw_fidelity(const std::vector<FidelityRow>& rows, const std::string& title,
                   const std::filesystem::path& stem) {
  const std::vector<std::string> names = distinct(rows, &FidelityRow::dataset);
  const int panels = static_cast<int>(names.size());
  const int down = (panels + most_across - 1) / most_across;
  Canvas canvas(left_margin + std::min(most_across, panels) * (panel_width + gap) + 6,
                top + down * row_height + notes_height);
  canvas.title(title);
  Span span;
  double least = INFINITY;
  double most = 0;
  for (const FidelityRow& row : rows) {
    span.extend(row.time_low);
    span.extend(row.time_high);
    least = std::min(least, row.error_median);
    most = std::max(most, row.error_max);
  }
  const Axis times{span.low / 1.5, span.high * 1.5, true, time_ticks(),
                   "time of a scene, one thread"};
  Axis errors = Axis::logarithms({std::max(least, 1e-5 * most) / 2, most * 1.6});
  for (int p = 0; p < panels; ++p) {
    const std::string& name = names[static_cast<std::size_t>(p)];
    const double left = left_margin + p % most_across * (panel_width + gap);
    const double upper = top + p / most_across * row_height;
    errors.title = p % most_across == 0 ? "error of the voltages / noise" : "";
    plot_models(canvas, rows, name, Box::sized(left, upper, panel_width, panel_height), times,
                errors);
    draw_sizes(canvas, rows, name, left, upper + to_bars);
  }
  const double upper = top + down * row_height - 8;
  Legend sizes(left_margin, canvas.width());
  sizes.add({"Bars: scenes of \"auto\" by points of the border equation:"});
  sizes.new_line();
  for (std::size_t s = 0; s <= std::size(fidelity_sizes); ++s) {
    const bool last = s == std::size(fidelity_sizes);
    sizes.add({last ? "more" : "≤ " + std::to_string(fidelity_sizes[s]), {}, {}, shade(s)});
  }
  sizes.draw(canvas, upper);
  const TextStyle style{.size = 9, .align = TextAlign::left, .colour = ink::note};
  const double y = upper + sizes.height() + 4;
  canvas.text(
      "Points: medians; whiskers up to the largest error, and from 5 to 95 % of the "
      "times. Dashed: the bound that \"auto\" promises.",
      left_margin, y, style);
  canvas.text(
      "smooth: whole discs and ellipses apart from each other; other: corners, "
      "overlaps, contacts cut by the border of the sheet.",
      left_margin, y + 16, style);
  canvas.draw(stem);
}

std::string digits(double value, const char* format = "%.4g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

/// The table of fidelity.csv.
TableSection data_of(const std::vector<FidelityRow>& rows) {
  TableSection section;
  section.columns = columns_named(
      "dataset scenes model count time_us time_p5_us time_p95_us error_median error_p95 error_max "
      "bound within_bound promised promised_and_kept estimate_over_error");
  for (const int size : fidelity_sizes) {
    section.columns.emplace_back("points_to_" + std::to_string(size));
  }
  section.columns.emplace_back("points_more");
  for (const FidelityRow& row : rows) {
    std::vector<Cell>& cells = section.rows.emplace_back();
    cells = {row.dataset, row.scenes, row.model, std::to_string(row.count)};
    for (const double value : {row.time_us, row.time_low, row.time_high, row.error_median,
                               row.error_p95, row.error_max}) {
      cells.emplace_back(digits(value));
    }
    cells.emplace_back(digits(row.bound, "%g"));
    cells.emplace_back(std::to_string(row.kept));
    if (automatic(row)) {
      cells.emplace_back(std::to_string(row.promised));
      cells.emplace_back(std::to_string(row.promised_kept));
      cells.emplace_back(digits(row.tightness, "%.3g"));
      for (const int count : row.sizes) cells.emplace_back(std::to_string(count));
    }
    cells.resize(section.columns.size());
  }
  return section;
}

/// The table of fidelity.md.
TableSection models_section(const std::vector<FidelityRow>& rows) {
  TableSection section;
  section.caption = "The models";
  section.columns = {
      {"dataset", Align::left}, {"scenes", Align::left}, "number", {"model", Align::left}};
  for (const char* title : {"time (µs)", "scenes/s", "median error", "95 % of error", "largest",
                            "within the bound", "kept of promised", "estimate / error"}) {
    section.columns.emplace_back(title);
  }
  for (const FidelityRow& row : rows) {
    const bool promises = automatic(row);
    Cell time = three_digits(row.time_us);
    time.interval = interval_text(three_digits(row.time_low), three_digits(row.time_high));
    section.rows.push_back(
        {row.dataset, row.scenes, std::to_string(row.count), row.model, time,
         three_digits(1e6 / row.time_us), three_digits(row.error_median),
         three_digits(row.error_p95), three_digits(row.error_max),
         fixed(100.0 * row.kept / row.count, 1) + " %",
         promises ? std::to_string(row.promised_kept) + " of " + std::to_string(row.promised) : "",
         promises ? three_digits(row.tightness) : ""});
  }
  return section;
}

Table table_of(const std::vector<FidelityRow>& rows, const Experiment& experiment) {
  Table table;
  table.title = experiment.title;
  table.text = experiment.question;
  table.sections = {models_section(rows)};
  table.legend = {
      "Errors are 2-norms over the channels in units of the frame's noise, against the border "
      "integral equation at a thousandth of the bound.",
      "Times are of one thread of " + cpu_name() + ", a scene: median of the blocks of " +
          std::to_string(fidelity_block) + ", 5 to 95 % in brackets.",
      "\"smooth\" are scenes of whole discs and ellipses apart from each other, \"other\" those "
      "with corners, overlaps or contacts cut by the border of the sheet; blank scenes are left "
      "out.",
      "\"kept of promised\": scenes whose error is within the bound, of those whose estimate is."};
  table.command = "./ertbench fidelity experiments/" + experiment.name + ".json";
  return table;
}

}  // namespace

void report_fidelity(const Experiment& experiment, const std::vector<FidelityOutcome>& outcomes,
                     const Builds& builds, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<FidelityRow> rows;
  std::vector<std::string> failures;
  for (const FidelityOutcome& outcome : outcomes) {
    rows.insert(rows.end(), outcome.rows.begin(), outcome.rows.end());
    if (!outcome.failure.empty()) {
      failures.push_back("Not measured: " + outcome.dataset + ", " + outcome.failure + ".");
    }
  }
  Table table = table_of(rows, experiment);
  table.sections.front().notes = failures;
  if (!builds.empty()) table.legend.push_back(text_of(builds));
  nlohmann::json origin = provenance(experiment, 1, {});
  origin["builds"] = to_json(builds);
  write_file_atomically(folder / "fidelity.csv", csv_of(data_of(rows)));
  write_file_atomically(folder / "fidelity.md", markdown_of(table));
  write_file_atomically(folder / "provenance.json", json_text(origin, 2) + "\n");
  if (!rows.empty()) {
    draw_or_say(folder / "fidelity",
                [&] { draw_fidelity(rows, experiment.title, folder / "fidelity"); });
  }
  std::printf("%s\nResults in %s\n", terminal_of(table).c_str(),
              printable_path(folder.string()).c_str());
}

}  // namespace ertbench
