#include "bench/check/check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "bench/check/noticeable.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t longest_status = 100;

std::string with_digits(double value, int digits = 5) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

/// " (40 %)".
std::string with_percent(double share) { return " (" + with_digits(100 * share, 2) + " %)"; }

/// Both with as many digits as it takes to tell them apart.
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
  /// `of_truth`: what the true images of the same test set score.
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

  /// Fewer are better, unless any other count is wrong.
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
      add(name_of(metric), values.empty() ? "-" : with_digits(centre_of(values)),
          now ? with_digits(*now) : "-", "", verdict);
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
    const auto texts = verdict == Verdict::ok ? std::pair(with_digits(before), with_digits(*now))
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

/// What the true images of a test set score; no values where they were not scored.
PerMetric<MetricSummary> truth_of(std::span<const ResultRow> rows, const std::string& dataset) {
  for (const ResultRow& row : rows) {
    if (row.type == "truth" && row.dataset == dataset) return row.metrics;
  }
  return {};
}

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::ok:
      return "ok";
    case Verdict::better:
      return "better";
    case Verdict::slower_warning:
      return "slower (warning)";
    case Verdict::slower:
      return "slower";
    case Verdict::missing:
      return "missing";
    case Verdict::worse:
      return "worse";
  }
  return "";
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
    RowComparison comparison(*before, row, name(row), context, truth_of(rows, row.dataset));
    const std::vector<CheckLine> of_row =
        comparison.lines(baseline.metrics, context.cpu == baseline.cpu);
    lines.insert(lines.end(), of_row.begin(), of_row.end());
  }
  for (const BaselineRow& row : baseline.rows) {
    const bool found =
        std::any_of(rows.begin(), rows.end(), [&](const ResultRow& now) { return row.is(now); });
    if (!found) lines.push_back({name(row), "row", row.status, "-", "", Verdict::missing});
  }
  return lines;
}

bool has_regression(std::span<const CheckLine> lines) {
  return std::any_of(lines.begin(), lines.end(),
                     [](const CheckLine& line) { return is_regression(line.verdict); });
}

}  // namespace ertbench
