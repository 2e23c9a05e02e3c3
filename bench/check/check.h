#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/check/baseline.h"
#include "bench/experiment/experiment.h"
#include "bench/record/result_row.h"
#include "bench/table/table.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

class SolverRegistry;

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

struct CheckOptions {
  std::filesystem::path out;       ///< result folder; empty: results/NAME/check, or see `reuse`
  std::filesystem::path baseline;  ///< empty: results/baselines/NAME.json of the project
  int jobs = 1;                    ///< as for a run
  bool all = false;                ///< show every quantity, not only changes
  bool update = false;             ///< write a new baseline
  bool images = false;             ///< only compare images with stored ones, which takes seconds
  /// With `update`: number of training seeds for a learned row. Nothing: the experiment's
  /// "baseline_seeds", or the entry's seeds if there are `enough_seeds`, otherwise `usual_seeds`.
  std::optional<int> seeds;
  /// With `update`: accept a baseline that does not notice worsenings of kNoticeLimits.
  bool accept_coarse = false;
  /// Use the results of `run` in the cache and in results/NAME: faster, but blind to changes of the
  /// program since. Otherwise everything is made by this very program.
  bool reuse = false;
  /// Only warn about times, as on another cpu: for machines with shared cores.
  bool warn_times = false;
};

/// With one training in a check, the interval of a trained row reaches 36 standard deviations to
/// each side for three seeds, 9.4 for five, 5.7 for eight, 5.0 for ten; each seed costs a training
/// of every network.
inline constexpr int enough_seeds = 5;
inline constexpr int usual_seeds = 8;
inline constexpr int most_seeds = 100;  ///< of CheckOptions::seeds

/// Runs the experiment and compares its rows with the baseline, and today's images of the stored
/// networks and of the short trainings with their stored images. Prints the comparison, with the
/// smallest worsening that it notices for every row and metric, and writes it to check.md in the
/// result folder. With `update` the baseline and the images of the short trainings are replaced,
/// all or none, and the changes are printed; stored networks are left unchanged. Returns true if
/// nothing regressed; with `update` if the baseline was written and stored networks agree.
///
/// Throws InputError, before anything is run, if the baseline is missing, malformed, or made with
/// other datasets or solvers.
bool check_experiment(const Experiment& experiment, SolverRegistry& registry,
                      const CheckOptions& options);

}  // namespace ertbench
