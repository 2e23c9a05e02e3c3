#include "bench/speed/speed_accuracy.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/record/limit_file.h"
#include "bench/report/result_table.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Share of frames that may lack a converged image.
constexpr double most_lost = 0.01;
/// An error counts as smaller only by more than this share, which rounding cannot cause.
constexpr double least_gain = 1e-3;
constexpr double margins[] = {0.01, 0.05, 0.20};
constexpr double contact_budgets_us[] = {50, 100, 200, 500, 1000};

std::string share_text(int part, int whole) {
  return fixed(100.0 * part / whole, part * 100 < whole * 10 ? 1 : 0) + " % of the frames";
}

void judge(const ResultRow& row, SpeedPoint& point) {
  if (!row.ok()) {
    point.standing = Standing::failed;
    point.remark = row.status;
  } else if (row.frames_not_converged > most_lost * row.frames) {
    point.standing = Standing::not_converged;
    point.remark = "not converged in " + share_text(row.frames_not_converged, row.frames);
  } else if (row.undefined_frames > most_lost * row.frames) {
    point.standing = Standing::not_converged;
    point.remark = "no image in " + share_text(row.undefined_frames, row.frames);
  }
}

SpeedPoint point_of(const ResultRow* row, const std::string& label, Metric metric,
                    const std::optional<RightSizing>& right_sizing) {
  SpeedPoint point;
  point.label = point.family = label;
  if (!row) {
    point.standing = Standing::failed;
    point.remark = "not run";
    return point;
  }
  point.type = row->type;
  point.family = row->family.empty() ? label : row->family;
  point.latency = row->latency_us;
  point.error = row->metrics[metric].mean;
  point.error_ci95 = row->metrics[metric].ci95;
  if (row->validation && right_sizing) {
    point.validation_error = (*row->validation)[right_sizing->metric].mean;
  }
  point.choice_error = row->validation ? (*row->validation)[metric].mean : std::nullopt;
  point.frames_per_s = row->frames_per_s;
  point.fit_s = row->fit_s;
  point.peak_rss_mb = row->peak_rss_mb;
  judge(*row, point);
  return point;
}

/// Removes times of another processor, which cannot be compared with the others.
void forget_times(const ResultRow& row, SpeedPoint& point) {
  point.latency.reset();
  point.frames_per_s.reset();
  if (point.remark.empty()) point.remark = "timed on another processor, " + row.timed_on->cpu;
}

/// Marks the points that no cheaper one beats; `cost` has no value for those that cannot join.
template <typename Cost>
void mark_frontier(std::vector<SpeedPoint>& points, bool SpeedPoint::*mark, const Cost& cost) {
  std::vector<SpeedPoint*> candidates;
  for (SpeedPoint& point : points) {
    if (point.standing == Standing::ok && point.error && cost(point)) candidates.push_back(&point);
  }
  std::ranges::sort(candidates, [&](const SpeedPoint* a, const SpeedPoint* b) {
    return std::pair(*cost(*a), *a->error) < std::pair(*cost(*b), *b->error);
  });
  double least = INFINITY;
  for (SpeedPoint* point : candidates) {
    point->*mark = *point->error < (1 - least_gain) * least;
    if (point->*mark) least = *point->error;
  }
}

/// The best point, by `better`, of the `allowed` ones.
template <typename Allowed, typename Better>
std::optional<std::size_t> choose(const std::vector<SpeedPoint>& points, const Allowed& allowed,
                                  const Better& better) {
  std::optional<std::size_t> chosen;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].standing != Standing::ok || !points[i].measured() || !allowed(points[i]))
      continue;
    if (!chosen || better(points[i], points[*chosen])) chosen = i;
  }
  return chosen;
}

/// Chooses on the validation set if all candidates were scored there, otherwise on the test set.
void settle_choice(SpeedAccuracy& chart) {
  const auto may_be = [](const SpeedPoint& p) {
    return p.standing == Standing::ok && p.measured();
  };
  chart.chosen_on_validation = std::ranges::any_of(chart.points, may_be) &&
                               std::ranges::all_of(chart.points, [&](const SpeedPoint& p) {
                                 return !may_be(p) || p.choice_error;
                               });
  if (chart.chosen_on_validation) return;
  for (SpeedPoint& point : chart.points) point.choice_error = point.error;
}

void choose_points(SpeedAccuracy& chart) {
  const auto smaller = [](const SpeedPoint& a, const SpeedPoint& b) {
    return a.choice_error < b.choice_error;
  };
  const auto faster = [](const SpeedPoint& a, const SpeedPoint& b) {
    return a.latency->p50 < b.latency->p50;
  };
  for (SpeedChoice& choice : chart.choices) {
    const auto keeps = [&](const SpeedPoint& p) {
      if (choice.margin) return true;
      if (choice.budget_us) return p.latency->p99 <= *choice.budget_us;
      return p.timed_to_contacts() && *p.latency->contacts_p99 <= *choice.contacts_budget_us;
    };
    const auto least = choose(chart.points, keeps, smaller);
    if (!least) continue;
    const double most =
        (1 + choice.margin.value_or(least_gain)) * *chart.points[*least].choice_error;
    choice.point = choose(
        chart.points, [&](const SpeedPoint& p) { return keeps(p) && *p.choice_error <= most; },
        faster);
  }
}

void choose_sizes(SpeedAccuracy& chart) {
  if (!chart.right_sizing) return;
  for (const std::string& family : distinct(chart.points, &SpeedPoint::family)) {
    std::vector<std::size_t> members;
    for (std::size_t i = 0; i < chart.points.size(); ++i) {
      const SpeedPoint& point = chart.points[i];
      if (point.family == family && point.standing == Standing::ok && point.validation_error) {
        members.push_back(i);
      }
    }
    if (members.size() < 2) continue;
    const auto error = [&](std::size_t i) { return *chart.points[i].validation_error; };
    const std::size_t best = std::ranges::min(members, {}, error);
    const double most = (1 + chart.right_sizing->margin) * error(best);
    const std::size_t chosen =
        *std::ranges::find_if(members, [&](std::size_t i) { return error(i) <= most; });
    chart.points[chosen].right_size = true;
    chart.right_sizes.push_back({family, best, chosen});
  }
}

void add_break_even(SpeedAccuracy& chart, const std::string& reference) {
  BreakEven out{reference, {}};
  const auto base = std::ranges::find(chart.points, reference, &SpeedPoint::label);
  for (const SpeedPoint& point : chart.points) {
    std::optional<double>& frames = out.frames.emplace_back();
    if (base == chart.points.end() || !base->latency || !base->fit_s) continue;
    if (!point.latency || !point.fit_s || point.label == reference) continue;
    const double gained_s = 1e-6 * (base->latency->p50 - point.latency->p50);
    if (gained_s > 0) frames = std::max(0.0, std::ceil((*point.fit_s - *base->fit_s) / gained_s));
  }
  chart.break_even.push_back(std::move(out));
}

}  // namespace

SpeedAccuracy speed_accuracy_of(const SpeedQuestion& question, std::span<const ResultRow> rows) {
  SpeedAccuracy chart;
  chart.metric = question.metric;
  chart.dataset = question.dataset;
  chart.right_sizing = question.right_sizing;
  const std::string usual = usual_processor(rows);
  for (const std::string& label : question.labels) {
    const ResultRow* row = find_row(rows, label, question.dataset);
    chart.points.push_back(point_of(row, label, chart.metric, question.right_sizing));
    if (row && timed_elsewhere(*row, usual)) forget_times(*row, chart.points.back());
    if (row) chart.batch = std::max(chart.batch, row->throughput_batch);
  }
  if (const ResultRow* nothing = find_row(rows, "no-contact", question.dataset)) {
    chart.nothing = nothing->metrics[chart.metric].mean;
  }
  if (const ResultRow* limit = limit_of(rows, question.dataset)) {
    chart.limit = limit->metrics[chart.metric].mean;
    chart.limit_frames = limit->frames;
    chart.limit_unresolved = limit->frames_not_converged;
    chart.limit_ci95 = limit->metrics[chart.metric].ci95;
  }
  mark_frontier(chart.points, &SpeedPoint::frontier,
                [](const SpeedPoint& p) { return member_of(p.latency, &LatencySummary::p50); });
  mark_frontier(chart.points, &SpeedPoint::batch_frontier, [](const SpeedPoint& p) {
    return p.frames_per_s ? std::optional(1 / *p.frames_per_s) : std::nullopt;
  });
  for (const double margin : margins) chart.choices.push_back({.margin = margin});
  for (const double us : question.budgets_us) chart.choices.push_back({.budget_us = us});
  for (const double us : contact_budgets_us) {
    if (std::ranges::none_of(chart.points, &SpeedPoint::timed_to_contacts)) break;
    chart.choices.push_back({.contacts_budget_us = us});
  }
  settle_choice(chart);
  choose_points(chart);
  choose_sizes(chart);
  for (const std::string& reference : question.break_even_against) add_break_even(chart, reference);
  return chart;
}

json to_json(const SpeedAccuracy& chart) {
  json out = {{"dataset", chart.dataset}, {"metric", name_of(chart.metric)}};
  out["chosen_on"] = chart.chosen_on_validation ? "validation" : "test";
  out["frontier"] = json::array();
  for (const SpeedPoint& point : chart.points) {
    if (point.frontier) out["frontier"].push_back(point.label);
  }
  out["within_budget"] = json::array();
  for (const SpeedChoice& choice : chart.choices) {
    const bool to_contacts = choice.contacts_budget_us.has_value();
    json& one = out[choice.margin ? "within_margin" : "within_budget"].emplace_back();
    one["label"] = choice.point ? json(chart.points[*choice.point].label) : json(nullptr);
    if (choice.margin) {
      one["margin"] = *choice.margin;
    } else {
      one["budget_us"] = to_contacts ? *choice.contacts_budget_us : *choice.budget_us;
    }
    if (to_contacts) one["to_contacts"] = true;
  }
  out["right_sizes"] = json::array();
  for (const RightSize& size : chart.right_sizes) {
    out["right_sizes"].push_back({{"family", size.family},
                                  {"best", chart.points[size.best].label},
                                  {"chosen", chart.points[size.chosen].label}});
  }
  out["break_even_frames"] = json::object();
  for (const BreakEven& one : chart.break_even) {
    json& frames = out["break_even_frames"][one.reference] = json::object();
    for (std::size_t i = 0; i < chart.points.size(); ++i) {
      frames[chart.points[i].label] = one.frames[i] ? json(*one.frames[i]) : json(nullptr);
    }
  }
  return out;
}

std::string time_text(double microseconds) {
  if (microseconds < 0.9995) return three_digits(microseconds * 1e3) + " ns";
  if (microseconds < 999.5) return three_digits(microseconds) + " µs";
  if (microseconds < 999.5e3) return three_digits(microseconds / 1e3) + " ms";
  if (microseconds < 60e6) return three_digits(microseconds / 1e6) + " s";
  return three_digits(microseconds / 60e6) + " min";
}

std::string rate_text(double per_second) {
  if (per_second < 999.5) return three_digits(per_second);
  if (per_second < 999.5e3) return three_digits(per_second / 1e3) + " k";
  if (per_second < 999.5e6) return three_digits(per_second / 1e6) + " M";
  return three_digits(per_second / 1e9) + " G";
}

std::string description(const SpeedPoint& point, const SpeedAccuracy& chart) {
  std::string text = point.label;
  const auto add = [&](const std::string& line) { text += "\n" + line; };
  if (point.error) {
    std::string line = "mean " + axis_title(chart.metric) + ": " + three_digits(*point.error);
    if (point.error_ci95) {
      line += " (95 %: " + three_digits(point.error_ci95->low) + " to " +
              three_digits(point.error_ci95->high) + ")";
    }
    add(line);
  }
  if (point.latency) {
    add("one frame: p50 " + time_text(point.latency->p50) + ", p99 " +
        time_text(point.latency->p99));
  }
  if (point.timed_to_contacts()) {
    add("to contacts: p50 " + time_text(*point.latency->contacts_p50) + ", p99 " +
        time_text(*point.latency->contacts_p99));
  }
  if (point.frames_per_s) {
    add(rate_text(*point.frames_per_s) + " frames/s, " + std::to_string(chart.batch) +
        " at a time");
  }
  if (point.fit_s) add("fit: " + time_text(1e6 * *point.fit_s));
  if (point.validation_error) add("validation error: " + three_digits(*point.validation_error));
  if (point.frontier) add("on the frontier");
  if (point.right_size) add("the smallest of its family that is good enough");
  if (!point.remark.empty()) add(point.remark);
  return text;
}

}  // namespace ertbench
