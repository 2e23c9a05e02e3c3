#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bench/pages/result_rows.h"

namespace ertbench {

/// What an expression comes to: numbers, each with the label of its row (empty for what was
/// computed), or a text.
struct PageValue {
  std::vector<std::pair<std::string, double>> numbers;
  std::string text;

  double number() const;  ///< the only one; throws InputError where there is another count of them
};

/// Evaluates what stands between a page's double braces:
///
/// - a number;
/// - `(FILE SELECTION COLUMN)`, the numbers of that column in the selected rows (ResultRows), the
///   outer parentheses left out where nothing stands around them; a word with blanks stands in
///   single quotes;
/// - `(+ a b)`, `-`, `*`, `/`, `abs`; `(ratio a b)` is `/`, `(difference a b)` is `-`;
/// - `min`, `max`, `mean`, `median`, `sum`, `count` over all numbers of their arguments;
///   `(range a ...)`, the least and the greatest; `(best a)` and `(worst a)`, the label of the row
///   with the least and the greatest number;
/// - `(< a b)`, `<=`, `>`, `>=`, which hold where every number of `a` compares so with every number
///   of `b`; `(= a b tolerance)`; `(order a b ...)`: every number of one is less than all of the
///   next; `(and ...)`, `(or ...)`, `(not a)`; `(is TEXT TEXT)`. 1 holds, 0 does not.
///
/// Throws InputError for what it cannot understand and for a row or a value that is not there.
PageValue evaluate(std::string_view expression, ResultRows& results);

/// `value` as a page shows it. `format`: `.3f`, `.2g`, `.1%` (a share), `d` (whole, in threes),
/// `us` (a time in µs, with its unit), or nothing for text, in which nothing is markup. A range is
/// "low to high", a list has commas.
std::string formatted(const PageValue& value, const std::string& format);
std::string formatted(double number, const std::string& format);

/// Words of an expression, and its parentheses; quotes taken off.
std::vector<std::string> words_of(std::string_view expression);

}  // namespace ertbench
