#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/check/baseline.h"
#include "bench/record/result_row.h"
#include "bench/table/table.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The smallest worsening of one metric of one row that a check reports: any that is larger comes
/// out as "worse".
///
/// For a trained solver it is the half width of an interval around the mean of its seeds
/// (allowed_change), and so what today's own mean must have lost. Where the code makes every
/// training worse by just this amount, half of the checks see it, as today's mean scatters, too; of
/// 1.33 times this amount nine in ten see it (with 20 old seeds 3.88 + 1.28 standard deviations in
/// place of 3.88).
struct Noticeable {
  std::string row;  ///< its label
  std::string dataset;
  Metric metric = Metric::AR;
  ToleranceClass type = ToleranceClass::exact;
  double centre = 0;  ///< what the baseline has
  double amount = 0;  ///< in the metric's own unit

  /// As a part of what the baseline has, for the errors, whose ideal is 0; else none.
  std::optional<double> share() const;
  /// The amount as a part of what a baseline may have (kNoticeLimits); none for other metrics, or
  /// where the limit is a part of nothing.
  std::optional<double> part_of_limit() const;
};

/// How large a worsening of a trained solver may stay unnoticed.
struct NoticeLimit {
  Metric metric;
  double most;
  bool of_value;  ///< a part of the baseline's value; else in the metric's own unit
};
inline constexpr NoticeLimit kNoticeLimits[] = {{Metric::AR, 0.03, false},
                                                {Metric::PE, 0.25, true},
                                                {Metric::RIE, 0.1, true},
                                                {Metric::relative_error, 0.1, true}};

/// Of all rows and metrics that the baseline has values of, in its order. `trainings`: of each
/// network in a check.
std::vector<Noticeable> noticeable_worsenings(const Baseline& baseline, const Sensor& sensor,
                                              int trainings);

/// Those of trained solvers that are beyond their limit.
std::vector<Noticeable> beyond_limits(std::span<const Noticeable> all);

/// The fewest trainings behind a baseline of now `seeds` with which all of `coarse` would be within
/// their limits, if more scatter as those do; none where `most` are too few. `trainings`: of each
/// network in a check.
std::optional<int> seeds_that_would_do(std::span<const Noticeable> coarse, int seeds, int trainings,
                                       int most);

/// "0.021 (5.9 %)", or "0.021" where there is no share.
std::string text_of(const Noticeable& one);

/// "weakest: dcnn AR, noticed from 0.021", the largest part of its limit; empty where no metric has
/// a limit.
std::string weakest_text(std::span<const Noticeable> all);

enum class Verdict {
  ok,              ///< within what is allowed
  better,          ///< beyond what is allowed, in the right direction
  slower_warning,  ///< slower than allowed, on another cpu than the baseline's
  slower,          ///< the same on the same cpu
  missing,         ///< in the baseline and not in the results, or the other way round
  worse,
};

/// "ok", "better", "slower (warning)", "slower", "missing", "worse".
const char* name_of(Verdict verdict);
/// Whether it makes the check fail: slower, missing or worse.
bool is_regression(Verdict verdict);

/// One quantity of one row.
struct CheckLine {
  std::string row;  ///< its label, with the test set where there are several
  std::string quantity;
  std::string before;   ///< as the baseline has it
  std::string now;      ///< as it came out
  std::string notices;  ///< the smallest worsening that counts as one: "0.021 (5.9 %)"
  Verdict verdict = Verdict::ok;
};

/// Where the rows come from.
struct CheckContext {
  std::string cpu;     ///< on which they were timed
  Sensor sensor = {};  ///< whose images they score
};

/// Every quantity of every row against the baseline, row by row in the order of `rows`; then what
/// is missing. A row or a value that the baseline does not have is missing as well: it may have
/// lost it. Of a change beyond what is allowed, better is what brings a metric nearer to its ideal
/// (metric_table.h). Any other is worse, also one to the other side of the ideal at the same
/// distance, and any of the truth. A metric that did not exist when the baseline was stored is not
/// compared. Counts and statuses are exact. Of a row that failed only the status is compared.
std::vector<CheckLine> compare(const Baseline& baseline, std::span<const ResultRow> rows,
                               const CheckContext& context);

bool has_regression(std::span<const CheckLine> lines);

/// Columns row, quantity, old, new, notices, verdict, for the terminal: what is not "ok" (or every
/// line, with `all`), and after each row's lines one for the whole row with its worst verdict.
Table check_table(std::span<const CheckLine> lines, bool all);

/// All lines.
Table check_report(std::span<const CheckLine> lines);

/// A row for each row of the baseline and a column for each metric: from where on a worsening is
/// noticed.
Table noticeable_table(std::span<const Noticeable> all);

/// How many rows came out how: "7 rows ok, 1 better, 1 worse".
std::string check_summary(std::span<const CheckLine> lines);

}  // namespace ertbench
