#include "bench/training/training_budget.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_charts.h"
#include "bench/plot/panel.h"
#include "bench/score/metrics.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Epochs times scenes of one training; 0 if its parameters lack them.
double scenes_seen(const json& parameters) {
  const json training = parameters.is_object() ? parameters.value("training", json()) : json();
  const auto number = [&](const char* key) {
    const json value = training.is_object() ? training.value(key, json()) : json();
    return value.is_number() ? value.get<double>() : 0.0;
  };
  return number("epochs") * number("scenes");
}

double mean_scenes_seen(const ResultRow& row) {
  std::vector<double> seen;
  if (row.seeds) {
    for (const json& different : *row.seeds->parameters) seen.push_back(scenes_seen(different));
  }
  std::erase(seen, 0);
  return seen.empty() ? scenes_seen(*row.parameters) : mean(seen);
}

/// From the least to the largest mean of one training.
Interval trainings_of(const ResultRow& row, Metric metric) {
  const double all = *row.metrics[metric].mean;
  Interval out{all, all};
  if (!row.seeds) return out;
  for (const std::optional<double>& one : row.seeds->means[metric]) {
    out = {std::min(out.low, one.value_or(all)), std::max(out.high, one.value_or(all))};
  }
  return out;
}

/// Why a row has no point; empty if it has one.
std::string reason_of(const ResultRow* row, const std::optional<double>& cost, Metric metric) {
  if (!row) return "not run";
  if (!row->ok()) return row->status;
  if (convergence_of(*row).runs == 0 || !cost || *cost <= 0) return "not trained";
  return row->metrics[metric].mean ? "" : "no error";
}

BudgetLine& line_of(std::vector<BudgetLine>& lines, const std::string& family) {
  const auto found = std::ranges::find(lines, family, &BudgetLine::family);
  if (found != lines.end()) return *found;
  lines.push_back({family, {}});
  return lines.back();
}

// Places and sizes in px.
constexpr int width = 860;
constexpr Box box{72, 44, 836, 424};
constexpr double legend_top = 492;
constexpr double mark_radius = 5;

constexpr LineStyle whisker_line{ink::light, 1};
constexpr LineStyle nothing_line{rgb(0x606060), 1, 3};

const char* title_of(TrainingCost cost) {
  return cost == TrainingCost::seconds ? "time of the training, s" : "scenes seen in training";
}

/// "lean-net, -6 %": with what the last doubling of the cost changed.
std::string name_of(const BudgetLine& line) {
  if (line.flat()) return line.family + ", flat";
  const std::optional<double> change = line.last_doubling();
  return change ? line.family + ", " + number_text(std::round(100 * *change)) + " %" : line.family;
}

/// "20", "5000", "60 k", "2 M".
std::string short_number(double value) {
  if (value >= 1e6) return number_text(value / 1e6) + " M";
  return value >= 1e4 ? number_text(value / 1e3) + " k" : number_text(value);
}

class BudgetDrawing {
 public:
  BudgetDrawing(const TrainingBudgets& budgets, const std::string& title)
      : budgets_(budgets),
        styles_(distinct(budgets.lines, &BudgetLine::family)),
        legend_(legend()),
        canvas_(width, legend_top + legend_.height()),
        panel_(canvas_, box, cost_axis(), error_axis()) {
    canvas_.title(title);
  }

  void draw(const std::filesystem::path& stem) {
    if (budgets_.lines.empty()) {
      canvas_.text("no training has a result", box.middle(), box.centre(), {.size = 11});
    } else {
      plot();
    }
    name_what_is_missing();
    legend_.draw(canvas_, legend_top);
    canvas_.draw(stem);
  }

 private:
  Span costs() const {
    Span span;
    for (const BudgetLine& line : budgets_.lines) {
      for (const BudgetPoint& point : line.points) span.extend(point.cost);
    }
    return span.empty() ? Span{1, 10} : span;
  }

  /// Leaves room at the right for the names at the ends of the lines.
  Axis cost_axis() const {
    const Span span = costs();
    const double decades = std::max(0.5, std::log10(span.high / span.low));
    Axis axis = Axis::logarithms(
        {span.low / std::pow(10, 0.05 * decades), span.high * std::pow(10, 0.24 * decades)},
        title_of(budgets_.cost));
    for (Tick& tick : axis.ticks) tick.text = short_number(tick.value);
    return axis;
  }

  bool shows_nothing() const {
    return budgets_.nothing && *budgets_.nothing <= errors().high * 1.3;
  }

  Span errors() const {
    Span span;
    for (const BudgetLine& line : budgets_.lines) {
      for (const BudgetPoint& point : line.points) {
        span.extend(point.ci95 ? point.ci95->low : point.error);
        span.extend(point.ci95 ? point.ci95->high : point.error);
      }
    }
    return span.empty() ? Span{0, 1} : span;
  }

  Axis error_axis() const {
    Span span = errors();
    if (shows_nothing()) span.extend(*budgets_.nothing);
    const double margin = std::max(0.06 * (span.high - span.low), 0.01 * std::abs(span.high));
    span.low = span.low < 0.15 * span.high ? 0 : span.low - margin;
    span.high += margin;
    return Axis::even(span, "mean " + axis_title(budgets_.metric));
  }

  void plot() {
    std::vector<Box> taken;
    if (shows_nothing()) add_nothing(taken);
    std::vector<PointLabel> names;
    for (std::size_t f = 0; f < budgets_.lines.size(); ++f) add_line(f, names, taken);
    panel_.draw();
    panel_.labels(names, taken);
  }

  void add_nothing(std::vector<Box>& taken) {
    panel_.level(*budgets_.nothing, nothing_line);
    const double y = panel_.y(*budgets_.nothing);
    canvas_.text("an empty image", box.right - 4, y + 8,
                 {.size = 9, .align = TextAlign::right, .colour = nothing_line.colour});
    taken.push_back({box.left, y - 1, box.right, y + 1});
    taken.push_back({box.right - 110, y, box.right, y + 15});
  }

  void add_line(std::size_t family, std::vector<PointLabel>& names, std::vector<Box>& taken) {
    const BudgetLine& line = budgets_.lines[family];
    Points points;
    Points hollow_points;
    Points filled_points;
    std::vector<Whisker> whiskers;
    std::vector<Whisker> trainings;
    for (const BudgetPoint& point : line.points) {
      points.emplace_back(point.cost, point.error);
      (point.converged ? filled_points : hollow_points).push_back(points.back());
      if (point.ci95) whiskers.push_back({point.cost, point.ci95->low, point.ci95->high});
      trainings.push_back({point.cost, point.trainings.low, point.trainings.high});
      panel_.tooltip(point.cost, point.error, text_of(point));
    }
    panel_.band(trainings, styles_.colour(family).towards_white(0.7));
    panel_.whiskers(whiskers, whisker_line);
    panel_.line(points, styles_.line(family, 1.5));
    // The white mark below hides the line inside the hollow one.
    const MarkStyle converged = styles_.filled_mark(family, 1);
    panel_.marks(hollow_points, {converged.shape, ink::white, 1});
    panel_.marks(hollow_points, styles_.hollow_mark(family, 1));
    panel_.marks(filled_points, converged);
    occupy(points, taken);
    names.push_back({name_of(line), panel_.x(points.back().first), panel_.y(points.back().second),
                     styles_.colour(family).for_text()});
  }

  /// Adds the marks and short pieces of the line, which names must not cover.
  void occupy(const Points& points, std::vector<Box>& taken) const {
    constexpr int pieces = 24;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double x = panel_.x(points[i].first);
      const double y = panel_.y(points[i].second);
      taken.push_back(Box::around(x, y, mark_radius));
      if (i == 0) continue;
      const double dx = x - panel_.x(points[i - 1].first);
      const double dy = y - panel_.y(points[i - 1].second);
      for (int p = 1; p < pieces; ++p) {
        taken.push_back(Box::around(x - dx * p / pieces, y - dy * p / pieces, 2));
      }
    }
  }

  std::string text_of(const BudgetPoint& point) const {
    std::string text = point.label + "\n" + title_of(budgets_.cost) + ": " +
                       three_digits(point.cost) + "\n" + axis_title(budgets_.metric) + ": " +
                       three_digits(point.error);
    if (point.ci95) {
      text += " [" + three_digits(point.ci95->low) + ", " + three_digits(point.ci95->high) + "]";
    }
    return text + (point.converged ? "" : "\nhad not converged");
  }

  void name_what_is_missing() {
    double y = box.top + 8;
    for (const auto& [label, reason] : budgets_.without) {
      canvas_.text("✕ " + one_line(label + ": " + reason, 60), box.right - 4, y,
                   {.align = TextAlign::right, .colour = ink::alarm});
      y += 14;
    }
  }

  Legend legend() const {
    Legend legend(box.left, width - 20);
    for (std::size_t f = 0; f < budgets_.lines.size(); ++f) {
      legend.add({budgets_.lines[f].family, styles_.line(f, 1.5), styles_.filled_mark(f, 1)});
    }
    legend.new_line();
    legend.add({"hollow: had not converged, the best epoch was the last of the budget",
                {},
                MarkStyle{circle, ink::dark}});
    legend.add({"vertical bar: 95 % interval of the mean; band: between trainings"});
    legend.new_line();
    legend.add({"behind a name: change of the error over the last doubling; flat: less than 1 %"});
    return legend;
  }

  const TrainingBudgets& budgets_;
  MethodStyles styles_;
  Legend legend_;
  Canvas canvas_;
  Panel panel_;
};

BudgetQuestion read_question(const ChartRequest& request) {
  JsonObject& object = request.object;
  BudgetQuestion question;
  question.dataset = request.place.dataset;
  question.labels = read_row_labels(object, request.experiment);
  question.metric = metric_from_name(
      object.choice_or("metric", name_of(question.metric), accepted_names(kErrorMetrics)));
  if (object.choice_or("cost", "seconds", {"seconds", "scenes"}) == "scenes") {
    question.cost = TrainingCost::scenes;
  }
  return question;
}

}  // namespace

std::optional<double> BudgetLine::last_doubling() const {
  if (points.size() < 2) return std::nullopt;
  const BudgetPoint& before = points[points.size() - 2];
  const double doublings = std::log2(points.back().cost / before.cost);
  if (!(doublings > 0) || before.error <= 0 || points.back().error <= 0) return std::nullopt;
  return std::pow(points.back().error / before.error, 1 / doublings) - 1;
}

bool BudgetLine::flat() const {
  const std::optional<double> change = last_doubling();
  return change && std::abs(*change) < flat_below;
}

TrainingBudgets training_budgets_of(const BudgetQuestion& question,
                                    std::span<const ResultRow> rows) {
  TrainingBudgets out;
  out.metric = question.metric;
  out.cost = question.cost;
  for (const std::string& label : question.labels) {
    const ResultRow* row = find_row(rows, label, question.dataset);
    std::optional<double> cost;
    if (row) cost = out.cost == TrainingCost::seconds ? row->fit_s : mean_scenes_seen(*row);
    if (const std::string reason = reason_of(row, cost, question.metric); !reason.empty()) {
      out.without.emplace_back(label, reason);
      continue;
    }
    const MetricSummary& summary = row->metrics[question.metric];
    line_of(out.lines, row->family.empty() ? label : row->family)
        .points.push_back({label, *cost, *summary.mean, summary.ci95,
                           trainings_of(*row, out.metric), convergence_of(*row).all()});
  }
  for (BudgetLine& line : out.lines) {
    std::ranges::stable_sort(
        line.points, [](const BudgetPoint& a, const BudgetPoint& b) { return a.cost < b.cost; });
  }
  if (const ResultRow* nothing = find_row(rows, "no-contact", question.dataset)) {
    out.nothing = nothing->metrics[question.metric].mean;
  }
  return out;
}

void draw_training_budgets(const TrainingBudgets& budgets, const std::string& title,
                           const std::filesystem::path& stem) {
  BudgetDrawing(budgets, title).draw(stem);
}

TrainingBudgetChart::TrainingBudgetChart(const ChartRequest& request)
    : Chart(request.place), question_(read_question(request)) {}

void TrainingBudgetChart::draw(std::span<const ResultRow> rows, const std::string& title,
                               const std::filesystem::path& folder) const {
  draw_training_budgets(training_budgets_of(question_, rows), title, folder / name());
}

std::string TrainingBudgetChart::caption() const {
  return "means of the " + axis_title(question_.metric) + " with their 95 % intervals over " +
         (question_.cost == TrainingCost::seconds ? "the time of the training"
                                                  : "the scenes seen in training") +
         ", test set " + dataset();
}

}  // namespace ertbench
