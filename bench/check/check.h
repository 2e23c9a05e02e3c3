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

/// The smallest worsening of one metric of one row that a check reports as "worse".
///
/// For a trained solver it is the half width of an interval around the mean of its seeds
/// (allowed_change), the loss that today's mean must show. A change of the code that makes every
/// training worse by this amount is seen by half of the checks, as today's mean scatters too; one
/// of 1.33 times this amount by nine in ten (with 20 old seeds 3.88 + 1.28 standard deviations
/// instead of 3.88).
struct Noticeable {
  std::string row;  ///< its label
  std::string dataset;
  Metric metric = Metric::AR;
  ToleranceClass type = ToleranceClass::exact;
  double centre = 0;  ///< the baseline's value
  double amount = 0;  ///< in the metric's own unit

  /// The amount relative to the baseline's value, for errors, whose ideal is 0; otherwise nothing.
  std::optional<double> share() const;
  /// The amount relative to its limit (kNoticeLimits); nothing without a limit or if it is 0.
  std::optional<double> part_of_limit() const;
};

/// The largest worsening of a trained solver that may stay unnoticed.
struct NoticeLimit {
  Metric metric;
  double most;
  bool of_value;  ///< relative to the baseline's value; otherwise in the metric's own unit
};
inline constexpr NoticeLimit kNoticeLimits[] = {{Metric::AR, 0.03, false},
                                                {Metric::PE, 0.25, true},
                                                {Metric::RIE, 0.1, true},
                                                {Metric::relative_error, 0.1, true}};

/// All rows and metrics with values in the baseline, in its order. `trainings`: number of trainings
/// of each network in a check.
std::vector<Noticeable> noticeable_worsenings(const Baseline& baseline, const Sensor& sensor,
                                              int trainings);

/// The elements of trained solvers that exceed their limit.
std::vector<Noticeable> beyond_limits(std::span<const Noticeable> all);

/// The smallest number of trainings of a baseline, which has `seeds`, that would bring all of
/// `coarse` within their limits if further trainings scatter alike; nothing if `most` are too few.
/// `trainings`: number of trainings of each network in a check.
std::optional<int> seeds_that_would_do(std::span<const Noticeable> coarse, int seeds, int trainings,
                                       int most);

std::string with_digits(double value, int digits = 5);  ///< significant ones
/// "0.021 (5.9 %)", or "0.021" without a share.
std::string text_of(const Noticeable& one);

/// "weakest: dcnn AR, noticed from 0.021", the one closest to its limit; empty if no metric has
/// one.
std::string weakest_text(std::span<const Noticeable> all);

enum class Verdict {
  ok,              ///< within what is allowed
  better,          ///< beyond what is allowed, in the right direction
  slower_warning,  ///< slower than allowed, on another cpu than the baseline's
  slower,          ///< slower than allowed on the baseline's cpu
  missing,         ///< in the baseline and not in the results, or vice versa
  worse,
};

/// "ok", "better", "slower (warning)", "slower", "missing", "worse".
const char* name_of(Verdict verdict);
/// True if it makes the check fail: slower, missing or worse.
bool is_regression(Verdict verdict);

/// One quantity of one row.
struct CheckLine {
  std::string row;  ///< its label, with the test set if there are several
  std::string quantity;
  std::string before;   ///< the baseline's value
  std::string now;      ///< today's value
  std::string notices;  ///< the smallest worsening that counts as one: "0.021 (5.9 %)"
  Verdict verdict = Verdict::ok;
};

/// Origin of the rows.
struct CheckContext {
  std::string cpu;     ///< on which they were timed
  Sensor sensor = {};  ///< of their images
};

/// Compares every quantity of every row with the baseline, in the order of `rows`, and then lists
/// missing ones. A row or value that the baseline lacks is missing as well, since it may have been
/// lost. A change beyond the allowed one is better if it brings the metric nearer to its ideal
/// (metric_entries.h). Any other is worse, also one to the other side of the ideal at the same
/// distance, and any of the truth. Metrics that did not exist when the baseline was stored are not
/// compared. Counts and statuses are exact. For a failed row only the status is compared.
std::vector<CheckLine> compare(const Baseline& baseline, std::span<const ResultRow> rows,
                               const CheckContext& context);

bool has_regression(std::span<const CheckLine> lines);

/// For the terminal, columns row, quantity, old, new, notices, verdict: the lines that are not "ok"
/// (or every line, with `all`), and after each row's lines one with its worst verdict.
Table check_table(std::span<const CheckLine> lines, bool all);

/// For check.md: all lines.
Table check_report(std::span<const CheckLine> lines);

/// The smallest worsenings that are noticed: a row for each of the baseline, a column for each
/// metric.
Table noticeable_table(std::span<const Noticeable> all);

/// Counts of rows by verdict: "7 rows ok, 1 better, 1 worse".
std::string check_summary(std::span<const CheckLine> lines);

}  // namespace ertbench
