#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/check/baseline.h"
#include "bench/record/result_row.h"

namespace ertbench {

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

}  // namespace ertbench
