#include "bench/check/check.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t longest_status = 100;

/// " (40 %)".
std::string with_percent(double share) { return " (" + with_digits(100 * share, 2) + " %)"; }

/// Both numbers with enough digits to differ.
std::pair<std::string, std::string> distinct_texts(double before, double now) {
  for (int digits = 5;; ++digits) {
    auto texts = std::pair(with_digits(before, digits), with_digits(now, digits));
    if (texts.first != texts.second || digits == 17) return texts;
  }
}

std::string status_text(const ResultRow& row) {
  return one_line(row.ok() ? row.status : row.status + ": " + row.message, longest_status);
}

/// Compares one row with its row of the baseline.
class RowComparison {
 public:
  /// `of_truth`: metrics of the true images of the same test set; no values if they have none.
  RowComparison(const BaselineRow& before, const ResultRow& now, std::string name,
                const CheckContext& context, const PerMetric<MetricSummary>& of_truth)
      : before_(before),
        now_(now),
        name_(std::move(name)),
        context_(context),
        of_truth_(of_truth) {}

  /// `metrics`: those that the baseline knows.
  std::vector<CheckLine> lines(std::span<const Metric> metrics, bool same_cpu) {
    compare_status();
    if (now_.frames == 0 && before_.frames > 0) return std::move(lines_);
    compare_count("frames", before_.frames, now_.frames, before_.frames != now_.frames);
    compare_count("undefined frames", before_.undefined_frames, now_.undefined_frames);
    compare_count("frames not converged", before_.frames_not_converged, now_.frames_not_converged);
    for (const Metric metric : metrics) compare_metric(metric);
    compare_times(same_cpu);
    return std::move(lines_);
  }

 private:
  void add(const std::string& quantity, std::string before, std::string now, std::string noticed,
           Verdict verdict) {
    lines_.push_back(
        {name_, quantity, std::move(before), std::move(now), std::move(noticed), verdict});
  }

  void compare_status() {
    const bool same = before_.status == now_.status;
    const Verdict verdict = same ? Verdict::ok : now_.ok() ? Verdict::better : Verdict::worse;
    add("status", before_.status, same ? now_.status : status_text(now_), "", verdict);
  }

  /// Compares a count: fewer are better, or any difference is worse.
  void compare_count(const std::string& quantity, int before, int now, bool wrong = false) {
    Verdict verdict = wrong ? Verdict::worse : Verdict::ok;
    if (!wrong && now != before) verdict = now < before ? Verdict::better : Verdict::worse;
    add(quantity, std::to_string(before), std::to_string(now), "1", verdict);
  }

  double distance(Metric metric, double value) const {
    return distance_from_ideal(metric, value, of_truth_[metric].mean);
  }

  void compare_metric(Metric metric) {
    const std::vector<double>& values = before_.metrics[metric];
    const std::optional<double> now = now_.metrics[metric].mean;
    if (values.empty() || !now) {
      const Verdict verdict = !values.empty() ? Verdict::worse
                              : now           ? Verdict::missing
                                              : Verdict::ok;
      add(name_of(metric), values.empty() ? "-" : with_digits(centre_of(values), 5),
          now ? with_digits(*now, 5) : "-", "", verdict);
      return;
    }
    TodaysMean today{*now, {}};
    if (now_.seeds) today.seeds = now_.seeds->means[metric];
    const BaselineMean mean = mean_of(before_, metric, context_.sensor);
    const double before = centre_of(values);
    const double allowed = allowed_change(before_.tolerance, mean, today.trainings());
    Verdict verdict = Verdict::ok;
    if (is_beyond(before_.tolerance, mean, today)) {
      const bool better = before_.tolerance.type != ToleranceClass::exact &&
                          distance(metric, *now) < distance(metric, before);
      verdict = better ? Verdict::better : Verdict::worse;
    }
    const auto texts = verdict == Verdict::ok
                           ? std::pair(with_digits(before, 5), with_digits(*now, 5))
                           : distinct_texts(before, *now);
    add(name_of(metric), texts.first, texts.second,
        text_of({before_.label, before_.dataset, metric, before_.tolerance.type, before, allowed}),
        verdict);
  }

  void compare_times(bool same_cpu) {
    const std::optional<RelativeTimes> now = relative_times(now_);
    struct Quantity {
      const char* name;
      double RelativeTimes::*time;
      double allowed;
    };
    const Quantity quantities[] = {
        {"latency / calibration", &RelativeTimes::latency, allowed_slow_down},
        {"batch frame / calibration", &RelativeTimes::batch_frame, allowed_batch_slow_down}};
    for (const auto& [quantity, time, allowed] : quantities) {
      if (!before_.times) {
        if (now) add(quantity, "-", with_digits((*now).*time, 3), "", Verdict::missing);
        continue;
      }
      const double before = (*before_.times).*time;
      const double most = allowed * before;
      Verdict verdict = Verdict::ok;
      if (!now) {
        verdict = Verdict::missing;
      } else if ((*now).*time > most) {
        verdict = same_cpu ? Verdict::slower : Verdict::slower_warning;
      } else if (same_cpu && (*now).*time < before / allowed) {
        verdict = Verdict::better;
      }
      add(quantity, with_digits(before, 3), now ? with_digits((*now).*time, 3) : "-",
          with_digits(most - before, 2) + with_percent(allowed - 1), verdict);
    }
  }

  const BaselineRow& before_;
  const ResultRow& now_;
  std::string name_;
  const CheckContext& context_;
  PerMetric<MetricSummary> of_truth_;
  std::vector<CheckLine> lines_;
};

std::vector<Column> columns() {
  return {{"row", Align::left},    {"quantity", Align::left}, "old", "new", "notices",
          {"verdict", Align::left}};
}

std::vector<Cell> cells_of(const CheckLine& line) {
  return {line.row, line.quantity, line.before, line.now, line.notices, name_of(line.verdict)};
}

/// The lines of one row, which stand together.
std::vector<std::span<const CheckLine>> by_row(std::span<const CheckLine> lines) {
  std::vector<std::span<const CheckLine>> out;
  while (!lines.empty()) {
    const auto same = [&](const CheckLine& line) { return line.row == lines.front().row; };
    const auto end = std::ranges::find_if_not(lines, same);
    const auto count = static_cast<std::size_t>(end - lines.begin());
    out.push_back(lines.first(count));
    lines = lines.subspan(count);
  }
  return out;
}

Verdict worst(std::span<const CheckLine> lines) {
  return std::ranges::max(lines, {}, &CheckLine::verdict).verdict;
}

std::vector<Cell> summary_of(std::span<const CheckLine> row) {
  const auto ok = std::ranges::count(row, Verdict::ok, &CheckLine::verdict);
  const std::string all = std::to_string(row.size());
  const std::string quantities = row.size() == 1 ? " quantity" : " quantities";
  const bool every = static_cast<std::size_t>(ok) == row.size();
  return {row.front().row,
          (every ? all : std::to_string(ok) + " of " + all) + quantities,
          "",
          "",
          "",
          name_of(worst(row))};
}

}  // namespace

std::optional<double> Noticeable::share() const {
  const MetricEntry& entry = entry_of(metric);
  const bool error = entry.better == Better::smaller && centre != 0;
  return error ? std::optional(amount / std::abs(centre)) : std::nullopt;
}

std::optional<double> Noticeable::part_of_limit() const {
  for (const NoticeLimit& limit : kNoticeLimits) {
    if (limit.metric != metric || (limit.of_value && centre == 0)) continue;
    return amount / (limit.most * (limit.of_value ? std::abs(centre) : 1.0));
  }
  return std::nullopt;
}

std::vector<Noticeable> noticeable_worsenings(const Baseline& baseline, const Sensor& sensor,
                                              int trainings) {
  std::vector<Noticeable> out;
  for (const BaselineRow& row : baseline.rows) {
    for (const Metric metric : baseline.metrics) {
      const std::vector<double>& values = row.metrics[metric];
      if (values.empty()) continue;
      out.push_back({row.label, row.dataset, metric, row.tolerance.type, centre_of(values),
                     allowed_change(row.tolerance, mean_of(row, metric, sensor), trainings)});
    }
  }
  return out;
}

std::vector<Noticeable> beyond_limits(std::span<const Noticeable> all) {
  std::vector<Noticeable> out(all.begin(), all.end());
  std::erase_if(out, [](const Noticeable& one) {
    return one.type != ToleranceClass::seeds || one.part_of_limit().value_or(0) <= 1;
  });
  return out;
}

std::optional<int> seeds_that_would_do(std::span<const Noticeable> coarse, int seeds, int trainings,
                                       int most) {
  double beyond = 1;
  for (const Noticeable& one : coarse) beyond = std::max(beyond, one.part_of_limit().value_or(0));
  const double wanted = seeds_interval(seeds, trainings) / beyond;
  for (int n = seeds; n <= most; ++n) {
    if (seeds_interval(n, trainings) <= wanted) return n;
  }
  return std::nullopt;
}

std::string text_of(const Noticeable& one) {
  const std::optional<double> share = one.share();
  return with_digits(one.amount, 2) + (share ? with_percent(*share) : "");
}

std::string weakest_text(std::span<const Noticeable> all) {
  const auto weakest = std::ranges::max_element(
      all, {}, [](const Noticeable& one) { return one.part_of_limit().value_or(-1); });
  if (weakest == all.end() || !weakest->part_of_limit()) return "";
  return "weakest: " + weakest->row + " " + name_of(weakest->metric) + ", noticed from " +
         text_of(*weakest);
}

const char* name_of(Verdict verdict) {
  constexpr const char* names[] = {"ok",     "better",  "slower (warning)",
                                   "slower", "missing", "worse"};
  return names[static_cast<std::size_t>(verdict)];
}

bool is_regression(Verdict verdict) {
  return verdict == Verdict::slower || verdict == Verdict::missing || verdict == Verdict::worse;
}

std::vector<CheckLine> compare(const Baseline& baseline, std::span<const ResultRow> rows,
                               const CheckContext& context) {
  std::set<std::string> datasets;
  for (const ResultRow& row : rows) datasets.insert(row.dataset);
  for (const BaselineRow& row : baseline.rows) datasets.insert(row.dataset);
  const auto name = [&](const auto& row) {
    return datasets.size() > 1 ? row.label + " (" + row.dataset + ")" : row.label;
  };
  std::vector<CheckLine> lines;
  for (const ResultRow& row : rows) {
    const BaselineRow* before = baseline.find(row);
    if (!before) {
      lines.push_back({name(row), "row", "-", status_text(row), "", Verdict::missing});
      continue;
    }
    const ResultRow* truth = find_row(rows, "truth", row.dataset);
    RowComparison comparison(*before, row, name(row), context,
                             truth ? truth->metrics : PerMetric<MetricSummary>());
    const std::vector<CheckLine> of_row =
        comparison.lines(baseline.metrics, context.cpu == baseline.cpu);
    lines.insert(lines.end(), of_row.begin(), of_row.end());
  }
  for (const BaselineRow& row : baseline.rows) {
    if (find_row(rows, row.label, row.dataset)) continue;
    lines.push_back({name(row), "row", row.status, "-", "", Verdict::missing});
  }
  return lines;
}

bool has_regression(std::span<const CheckLine> lines) {
  return std::ranges::any_of(lines, is_regression, &CheckLine::verdict);
}

Table check_table(std::span<const CheckLine> lines, bool all) {
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.columns = columns();
  for (const auto& row : by_row(lines)) {
    for (const CheckLine& line : row) {
      if (all || line.verdict != Verdict::ok) section.rows.push_back(cells_of(line));
    }
    if (row.size() > 1) section.rows.push_back(summary_of(row));
  }
  return table;
}

Table check_report(std::span<const CheckLine> lines) {
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.columns = columns();
  for (const CheckLine& line : lines) section.rows.push_back(cells_of(line));
  return table;
}

Table noticeable_table(std::span<const Noticeable> all) {
  const bool several = distinct(all, &Noticeable::dataset).size() > 1;
  const auto metrics = distinct(all, &Noticeable::metric);
  Table table;
  TableSection& section = table.sections.emplace_back();
  section.caption = "The smallest worsening that this check notices";
  section.columns = {{"row", Align::left}};
  for (const Metric metric : metrics) section.columns.emplace_back(name_of(metric));
  std::string before;
  for (const Noticeable& one : all) {
    const std::string row = several ? one.row + " (" + one.dataset + ")" : one.row;
    if (section.rows.empty() || row != before) {
      section.rows.emplace_back(section.columns.size(), Cell("-")).front() = row;
      before = row;
    }
    const auto place = std::ranges::find(metrics, one.metric) - metrics.begin();
    section.rows.back()[static_cast<std::size_t>(place) + 1] = text_of(one);
  }
  return table;
}

std::string check_summary(std::span<const CheckLine> lines) {
  std::map<Verdict, int> counts;
  for (const auto& row : by_row(lines)) ++counts[worst(row)];
  std::string out;
  for (const auto& [verdict, count] : counts) {
    if (out.empty()) {
      out = std::to_string(count) + (count == 1 ? " row " : " rows ") + name_of(verdict);
    } else {
      out += ", " + std::to_string(count) + " " + name_of(verdict);
    }
  }
  return out.empty() ? "no rows" : out;
}

}  // namespace ertbench
