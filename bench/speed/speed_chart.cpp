#include "bench/speed/speed_chart.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_charts.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

using nlohmann::json;

const std::string dash = "—";

Cell error_cell(const SpeedPoint& point) {
  if (!point.error) return dash;
  Cell cell = three_digits(*point.error);
  cell.value = point.error;
  if (point.error_ci95) {
    cell.interval =
        interval_text(three_digits(point.error_ci95->low), three_digits(point.error_ci95->high));
  }
  return cell;
}

std::string p50_text(const SpeedPoint& point) {
  return point.latency ? time_text(point.latency->p50) : dash;
}

std::string p99_text(const SpeedPoint& point) {
  return point.latency ? time_text(point.latency->p99) : dash;
}

/// Range of the rounds' medians.
std::string rounds_text(const SpeedPoint& point) {
  if (!point.latency || point.latency->p50_of_rounds.empty()) return dash;
  const auto& rounds = point.latency->p50_of_rounds;
  const auto [least, most] = std::ranges::minmax_element(rounds);
  return time_text(*least) + " to " + time_text(*most);
}

std::string marks_of(const SpeedPoint& point) {
  std::string text = point.remark;
  const auto add = [&](bool set, const char* mark) {
    if (set) text += (text.empty() ? "" : ", ") + std::string(mark);
  };
  add(point.frontier, "frontier");
  add(point.batch_frontier, "frontier in batches");
  add(point.right_size, "right size");
  return text;
}

std::string wish_of(const SpeedChoice& choice) {
  if (choice.margin) {
    return "the fastest within " + fixed(100 * *choice.margin, 0) + " % of the least error";
  }
  const std::string least = "the least error with p99 ";
  if (choice.budget_us) return least + "within " + time_text(*choice.budget_us);
  return least + "to contacts within " + time_text(*choice.contacts_budget_us);
}

std::string contacts_text(const SpeedPoint& point, std::optional<double> LatencySummary::*part) {
  return point.timed_to_contacts() ? time_text(*((*point.latency).*part)) : dash;
}

bool any_to_contacts(const SpeedAccuracy& chart) {
  return std::ranges::any_of(chart.points, &SpeedPoint::timed_to_contacts);
}

void add_contact_columns(const SpeedAccuracy& chart, std::vector<Column>& columns) {
  if (!any_to_contacts(chart)) return;
  columns.push_back("to contacts, p50");
  columns.push_back("to contacts, p99");
}

void add_contact_cells(const SpeedAccuracy& chart, const SpeedPoint& point,
                       std::vector<Cell>& row) {
  if (!any_to_contacts(chart)) return;
  row.emplace_back(contacts_text(point, &LatencySummary::contacts_p50));
  row.emplace_back(contacts_text(point, &LatencySummary::contacts_p99));
}

TableSection choices(const SpeedAccuracy& chart) {
  TableSection section;
  section.caption = chart.chosen_on_validation
                        ? "What to take, chosen on the validation set; errors on the test set"
                        : "What to take, chosen on the test set: no validation set was scored";
  section.columns = {{"asked for", Align::left},
                     {"configuration", Align::left},
                     "mean " + axis_title(chart.metric) + " [95 %]",
                     "p50",
                     "p99"};
  add_contact_columns(chart, section.columns);
  SpeedPoint none;
  none.label = "none";
  for (const SpeedChoice& choice : chart.choices) {
    const SpeedPoint& point = choice.point ? chart.points[*choice.point] : none;
    std::vector<Cell>& row = section.rows.emplace_back();
    row = {wish_of(choice), point.label, error_cell(point), p50_text(point), p99_text(point)};
    add_contact_cells(chart, point, row);
  }
  return section;
}

TableSection right_sizes(const SpeedAccuracy& chart) {
  const std::string error = "mean " + axis_title(chart.right_sizing->metric) + ", validation";
  TableSection section;
  section.caption = "Right sizes: the smallest within " +
                    fixed(100 * chart.right_sizing->margin, 0) +
                    " % of the family's least validation error";
  section.columns = {{"family", Align::left},
                     {"best", Align::left},
                     error,
                     "p50",
                     {"right size", Align::left},
                     error,
                     "p50"};
  for (const RightSize& size : chart.right_sizes) {
    const SpeedPoint& best = chart.points[size.best];
    const SpeedPoint& chosen = chart.points[size.chosen];
    section.rows.push_back({size.family, best.label, three_digits(*best.validation_error),
                            p50_text(best), chosen.label, three_digits(*chosen.validation_error),
                            p50_text(chosen)});
  }
  return section;
}

std::string frames_text(const SpeedAccuracy& chart, const BreakEven& one, std::size_t point) {
  if (chart.points[point].label == one.reference) return dash;
  const auto measured = [](const SpeedPoint& one) { return one.latency && one.fit_s; };
  if (!measured(chart.points[point])) return dash;
  if (std::ranges::none_of(chart.points, [&](const SpeedPoint& other) {
        return other.label == one.reference && measured(other);
      })) {
    return dash;
  }
  if (!one.frames[point]) return "never";
  return *one.frames[point] == 0 ? "at once" : rate_text(*one.frames[point]);
}

TableSection configurations(const SpeedAccuracy& chart) {
  TableSection section;
  section.caption = "All configurations, from the fastest";
  section.columns = {{"configuration", Align::left},
                     "p50",
                     "p50 of the rounds",
                     "p99",
                     "frames/s",
                     "mean " + axis_title(chart.metric) + " [95 %]",
                     "validation",
                     "fit",
                     "memory"};
  add_contact_columns(chart, section.columns);
  for (const BreakEven& one : chart.break_even) {
    section.columns.emplace_back("frames until it pays against " + one.reference);
  }
  section.columns.emplace_back("remarks", Align::left);
  std::vector<std::size_t> order(chart.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) {
    return chart.points[i].latency ? chart.points[i].latency->p50 : INFINITY;
  });
  for (const std::size_t i : order) {
    const SpeedPoint& point = chart.points[i];
    std::vector<Cell> row = {point.label,
                             p50_text(point),
                             rounds_text(point),
                             p99_text(point),
                             point.frames_per_s ? rate_text(*point.frames_per_s) : dash,
                             error_cell(point),
                             point.validation_error ? three_digits(*point.validation_error) : dash,
                             point.fit_s ? time_text(1e6 * *point.fit_s) : dash,
                             point.peak_rss_mb ? fixed(*point.peak_rss_mb, 0) + " MB" : dash};
    add_contact_cells(chart, point, row);
    for (const BreakEven& one : chart.break_even) row.emplace_back(frames_text(chart, one, i));
    row.emplace_back(marks_of(point));
    section.rows.push_back(std::move(row));
  }
  return section;
}

/// A few sentences on how to read the tables.
std::string notes_on(const SpeedAccuracy& chart) {
  std::string text =
      "Time from raw voltages to the finished image of one frame, one thread; frames per second " +
      std::to_string(chart.batch) +
      " frames at a time, one thread. The frames are timed in rounds, all configurations in turn "
      "and never two at once. The error is the mean over the frames of the test set \"" +
      chart.dataset +
      "\" with its 95 % interval. A configuration that failed, or left more than 1 % of the frames "
      "without a converged image, is shown and takes no part in the frontier or in any choice.";
  if (!chart.break_even.empty()) {
    text +=
        " A longer fit pays after as many frames as its faster frames need to make good the time; "
        "\"never\" where its frames are slower.";
  }
  return text;
}

std::vector<double> read_budgets(JsonObject& object) {
  if (!object.has("budgets_us")) return {100, 1000, 10000};
  const json& values = object.raw("budgets_us");
  const bool positive = values.is_array() && std::ranges::all_of(values, [](const json& value) {
                          return value.is_number() && value > 0;
                        });
  if (!positive) object.fail("budgets_us", "must be a list of times in microseconds, all > 0");
  return values.get<std::vector<double>>();
}

/// The labels of "break_even_against"; by default the first row whose type is registered as a
/// reference for the break-even.
std::vector<std::string> read_references(const ChartRequest& request,
                                         const std::vector<std::string>& labels) {
  if (request.object.has("break_even_against")) {
    return request.object.choices("break_even_against", labels);
  }
  for (const auto& trials : request.experiment.rows()) {
    const SolverEntry& entry = trials.front();
    if (entry.break_even_reference && contains(labels, entry.label)) return {entry.label};
  }
  return {};
}

SpeedQuestion read_question(const ChartRequest& request) {
  JsonObject& object = request.object;
  if (!request.experiment.timing.enabled) {
    object.fail("type", "needs latencies; remove \"enabled\": false from /timing");
  }
  SpeedQuestion question;
  question.dataset = request.place.dataset;
  question.labels = read_row_labels(object, request.experiment);
  question.metric = metric_from_name(
      object.choice_or("metric", name_of(question.metric), accepted_names(kErrorMetrics)));
  question.budgets_us = read_budgets(object);
  question.right_sizing = request.experiment.right_sizing;
  question.break_even_against = read_references(request, question.labels);
  return question;
}

}  // namespace

Table speed_table(const SpeedAccuracy& chart, const std::string& title) {
  Table table;
  table.title = title;
  table.text = notes_on(chart);
  table.sections = {choices(chart)};
  if (!chart.right_sizes.empty()) table.sections.push_back(right_sizes(chart));
  table.sections.push_back(configurations(chart));
  return table;
}

TableSection speed_choices(const SpeedAccuracy& chart) {
  TableSection section;
  const bool to_contacts = any_to_contacts(chart);
  section.columns = columns_named(
      std::string("choice margin budget_us label error error_low error_high p50_us p99_us") +
      (to_contacts ? " contacts_budget_us contacts_p50_us contacts_p99_us" : ""));
  for (const SpeedChoice& choice : chart.choices) {
    const SpeedPoint point = choice.point ? chart.points[*choice.point] : SpeedPoint{};
    const auto time = [&](auto which) { return exact_cell(member_of(point.latency, which)); };
    std::vector<Cell>& row = section.rows.emplace_back();
    row = {wish_of(choice),
           exact_cell(choice.margin),
           exact_cell(choice.budget_us),
           point.label,
           exact_cell(point.error),
           exact_cell(member_of(point.error_ci95, &Interval::low)),
           exact_cell(member_of(point.error_ci95, &Interval::high)),
           time(&LatencySummary::p50),
           time(&LatencySummary::p99)};
    if (!to_contacts) continue;
    row.push_back(exact_cell(choice.contacts_budget_us));
    row.push_back(time(&LatencySummary::contacts_p50));
    row.push_back(time(&LatencySummary::contacts_p99));
  }
  return section;
}

SpeedChart::SpeedChart(const ChartRequest& request)
    : Chart(request.place), question_(read_question(request)) {}

void SpeedChart::draw(std::span<const ResultRow> rows, const std::string& title,
                      const std::filesystem::path& folder) const {
  const SpeedAccuracy answer = speed_accuracy_of(question_, rows);
  draw_speed_figure(answer, title, folder / name());
  if (answer.metric == Metric::relative_error) {
    draw_frontier_figure(answer, rows, folder / (name() + "_frontier"));
  }
  write_file_atomically(folder / (name() + ".md"), markdown_of(speed_table(answer, title)));
  write_file_atomically(folder / (name() + "_choices.csv"), csv_of(speed_choices(answer)));
}

std::string SpeedChart::caption() const {
  return "means of the " + axis_title(question_.metric) + " over the time of a frame, test set " +
         dataset();
}

Table SpeedChart::table(std::span<const ResultRow> rows) const {
  return speed_table(speed_accuracy_of(question_, rows), "");
}

void SpeedChart::summarise(std::span<const ResultRow> rows, json& summary) const {
  summary["speed_accuracy"][name()] = to_json(speed_accuracy_of(question_, rows));
}

}  // namespace ertbench
