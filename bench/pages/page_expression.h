#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/json.h"

namespace ertbench {

/// The rows of result files below one folder, read once each.
class ResultRows {
 public:
  explicit ResultRows(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The rows of `file` that `selection` names, in the file's order. `file`: a CSV or JSON file, or
  /// the folder of a result, whose summary.json is meant; of JSON the list "rows", or, where there
  /// is none, the one row that the file is, labelled with its name. `selection`: a
  /// label, where `*` stands for any text, or several with `|` between them; or conditions on
  /// columns, `axis=snr,solver=tsvd|pdipm,share>0.05`, all of which must hold.
  ///
  /// Whatever is named must exist, each of several too, and where `column` is given must have a
  /// value in it: a sentence about a row that was renamed or never filled would otherwise pass in
  /// silence. What `*`, `<`, `>` and `!=` select may be empty. Throws InputError where there is no
  /// such file, row or value, or where the file cannot be used.
  std::vector<const nlohmann::json*> select(const std::string& file, const std::string& selection,
                                            const std::string& column = "");

 private:
  const nlohmann::json& rows(const std::string& file);

  std::filesystem::path folder_;
  std::map<std::string, JsonValue> files_;
};

/// The value in a row at `column`: a key, or keys and indices with dots between them,
/// `latency_us.p50`. A metric's name alone is its mean, `RIE.ci95.0` the lower end of its interval.
/// Null where there is none.
const nlohmann::json& value_in(const nlohmann::json& row, const std::string& column);

/// The name of a row: its label, or its first column of CSV.
std::string label_of(const nlohmann::json& row);

/// The result of an expression: numbers, each with the label of its row, or a text.
struct PageValue {
  std::vector<std::pair<std::string, double>> numbers;
  std::string text;  ///< of numbers: "range" (the least and the greatest), "interval" or nothing

  double number() const;  ///< the only one; throws InputError where there is another count of them
};

/// Evaluates an expression of a page:
///
/// - a number;
/// - `(FILE SELECTION... COLUMN)`, the numbers of that column in the selected rows (ResultRows::
///   select; several selections must all hold), the outer parentheses left out where nothing stands
///   around them; a word with blanks stands in single quotes. `COLUMN~` is the number with its 95 %
///   interval (COLUMN.ci95 or COLUMN_low, COLUMN_high), `LOW..HIGH` the range of two columns;
/// - `(+ a b)`, `-`, `*`, `/`: each number of `a` with the one of `b`; `abs`;
/// - `min`, `max`, `sum`, `count` over all numbers of their arguments; `(range a ...)`, the least
///   and the greatest; `(best a)`, the label of the row with the least number;
/// - `(< a b ...)`, `>`, `>=`, which hold where every number of one argument compares so with every
///   number of the next; `(= a b tolerance)`; `(and ...)`, `(or ...)`;
///   `(is TEXT TEXT)`. 1 holds, 0 does not.
///
/// Throws InputError for what it cannot understand and for a row or a value that does not exist.
PageValue evaluate(std::string_view expression, ResultRows& results);

/// `value` as a page shows it. `format`: `.3f`, `.2g`, `.1%` (a share), `d` (whole, in threes),
/// `us` (a time in µs, with its unit), or nothing for text, in which nothing is markup. A range is
/// "low to high", an interval "value (low to high)", a list has commas.
std::string formatted(const PageValue& value, const std::string& format);
std::string formatted(double number, const std::string& format);

/// Words of an expression, and its parentheses; quotes taken off.
std::vector<std::string> words_of(std::string_view expression);

}  // namespace ertbench
