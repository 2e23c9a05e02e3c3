#include "bench/pages/page_expression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;
using Numbers = std::vector<std::pair<std::string, double>>;
using Arguments = std::vector<PageValue>;
using Operation = std::function<PageValue(const Arguments&)>;

PageValue of(double number) { return {{{"", number}}, ""}; }
PageValue of_text(std::string text) { return {{}, std::move(text)}; }

Numbers numbers_of(const Arguments& arguments) {
  Numbers out;
  for (const PageValue& argument : arguments) {
    out.insert(out.end(), argument.numbers.begin(), argument.numbers.end());
  }
  return out;
}

/// All numbers of the arguments, the least first.
Numbers sorted(const Arguments& arguments) {
  Numbers out = numbers_of(arguments);
  if (out.empty()) throw InputError("there is no number to take");
  std::ranges::stable_sort(out, [](const auto& a, const auto& b) { return a.second < b.second; });
  return out;
}

bool every_pair(const PageValue& a, const PageValue& b,
                const std::function<bool(double, double)>& compare) {
  if (a.numbers.empty() || b.numbers.empty()) throw InputError("there is nothing to compare");
  return std::ranges::all_of(a.numbers, [&](const auto& x) {
    return std::ranges::all_of(b.numbers,
                               [&](const auto& y) { return compare(x.second, y.second); });
  });
}

Operation arithmetic(double (*combine)(double, double)) {
  return [combine](const Arguments& a) {
    PageValue out = a.at(0);
    for (std::size_t i = 1; i < std::max<std::size_t>(2, a.size()); ++i) {
      for (auto& [label, value] : out.numbers) value = combine(value, a.at(i).number());
    }
    return out;
  };
}

Operation comparison(bool (*compare)(double, double)) {
  return [compare](const Arguments& a) {
    bool holds = every_pair(a.at(0), a.at(1), compare);
    for (std::size_t i = 2; i < a.size(); ++i) holds = holds && every_pair(a[i - 1], a[i], compare);
    return of(holds);
  };
}

const std::map<std::string, Operation>& operations() {
  static const std::map<std::string, Operation> all = {
      {"+", arithmetic([](double a, double b) { return a + b; })},
      {"-", arithmetic([](double a, double b) { return a - b; })},
      {"*", arithmetic([](double a, double b) { return a * b; })},
      {"/", arithmetic([](double a, double b) { return a / b; })},
      {"abs",
       [](const Arguments& a) {
         PageValue out = a.at(0);
         for (auto& [label, value] : out.numbers) value = std::abs(value);
         return out;
       }},
      {"min", [](const Arguments& a) { return of(sorted(a).front().second); }},
      {"max", [](const Arguments& a) { return of(sorted(a).back().second); }},
      {"best", [](const Arguments& a) { return of_text(sorted(a).front().first); }},
      {"range",
       [](const Arguments& a) {
         const Numbers all = sorted(a);
         return PageValue{{all.front(), all.back()}, "range"};
       }},
      {"sum",
       [](const Arguments& a) {
         double sum = 0;
         for (const auto& [label, value] : numbers_of(a)) sum += value;
         return of(sum);
       }},
      {"count", [](const Arguments& a) { return of(static_cast<double>(numbers_of(a).size())); }},
      {"<", comparison([](double a, double b) { return a < b; })},
      {">", comparison([](double a, double b) { return a > b; })},
      {">=", comparison([](double a, double b) { return a >= b; })},
      {"=",
       [](const Arguments& a) {
         const double tolerance = a.size() > 2 ? a[2].number() : 0;
         return of(every_pair(a.at(0), a.at(1),
                              [&](double x, double y) { return std::abs(x - y) <= tolerance; }));
       }},
      {"and",
       [](const Arguments& a) {
         return of(std::ranges::all_of(a, [](const auto& x) { return x.number() != 0; }));
       }},
      {"or",
       [](const Arguments& a) {
         return of(std::ranges::any_of(a, [](const auto& x) { return x.number() != 0; }));
       }},
      {"is", [](const Arguments& a) { return of(a.at(0).text == a.at(1).text); }},
  };
  return all;
}

/// The columns that a reference names: one, `LOW..HIGH`, or with `COLUMN~` the interval of it too.
std::vector<std::string> columns_of(const std::string& name, const json& row) {
  const std::size_t dots = name.find("..");
  if (dots != std::string::npos) return {name.substr(0, dots), name.substr(dots + 2)};
  if (!name.ends_with('~')) return {name};
  const std::string column = name.substr(0, name.size() - 1);
  if (row.contains(column + "_low")) return {column, column + "_low", column + "_high"};
  return {column, column + ".ci95.0", column + ".ci95.1"};
}

/// Reads words from left to right.
class Reader {
 public:
  Reader(std::vector<std::string> words, ResultRows& results)
      : words_(std::move(words)), results_(results) {}

  PageValue whole() {
    if (words_.empty()) throw InputError("there is nothing between the braces");
    PageValue value = words_.front() == "(" || words_.size() == 1 ? one() : list();
    if (next_ < words_.size()) throw InputError("what is \"" + words_[next_] + "\" for?");
    return value;
  }

 private:
  PageValue one() {
    const std::string word = take();
    if (word == "(") {
      PageValue value = list();
      if (take() != ")") throw InputError("a \")\" is missing");
      return value;
    }
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    return *end == '\0' && !word.empty() ? of(number) : of_text(word);
  }

  PageValue list() {
    const std::string head = take();
    const auto operation = operations().find(head);
    if (operation == operations().end()) return reference(head);
    Arguments arguments;
    while (next_ < words_.size() && words_[next_] != ")") arguments.push_back(one());
    try {
      return operation->second(arguments);
    } catch (const std::out_of_range&) {
      throw InputError("(" + head + " ...) takes more");
    }
  }

  PageValue reference(const std::string& file) {
    std::string selection = take();
    std::string column = take();
    while (next_ < words_.size() && words_[next_] != ")") {
      selection += "," + std::exchange(column, take());
    }
    PageValue out;
    const std::string first = columns_of(column, json::object()).front();
    for (const json* row : results_.select(file, selection, first)) {
      const std::vector<std::string> columns = columns_of(column, *row);
      if (columns.size() > 1) out.text = columns.size() == 2 ? "range" : "interval";
      for (const std::string& one : columns) {
        const json& value = value_in(*row, one);
        if (value.is_number()) out.numbers.emplace_back(label_of(*row), value.get<double>());
        if (value.is_string()) out.text = value.get<std::string>();
      }
    }
    if (out.numbers.empty() && out.text.empty() &&
        selection.find_first_of("<>!") == std::string::npos) {
      throw InputError("no " + column + " in the rows \"" + selection + "\" of " + file);
    }
    const std::size_t wanted = out.text == "range" ? 2 : out.text == "interval" ? 3 : 0;
    if (wanted > 0 && out.numbers.size() != wanted) {
      throw InputError(column + " takes one row with all of its values, not \"" + selection + "\"");
    }
    return out;
  }

  std::string take() {
    if (next_ >= words_.size()) throw InputError("it ends too early");
    return words_[next_++];
  }

  std::vector<std::string> words_;
  ResultRows& results_;
  std::size_t next_ = 0;
};

std::string printed(const char* pattern, double number) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, number);
  return text;
}

/// "1 234 567"
std::string in_threes(double number) {
  std::string digits = printed("%.0f", number);
  for (auto i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > 0; i -= 3) {
    if (digits.size() > 4 && digits[static_cast<std::size_t>(i) - 1] != '-') {
      digits.insert(static_cast<std::size_t>(i), " ");
    }
  }
  return digits;
}

}  // namespace

double PageValue::number() const {
  if (numbers.size() != 1) {
    throw InputError("one number is meant, and there are " + std::to_string(numbers.size()) +
                     (numbers.empty() && !text.empty() ? " (\"" + printable(text) + "\")" : ""));
  }
  return numbers.front().second;
}

PageValue evaluate(std::string_view expression, ResultRows& results) {
  return Reader(words_of(expression), results).whole();
}

std::string formatted(double number, const std::string& format) {
  if (format == "d") return in_threes(number);
  if (format == "us") {
    return number < 100 ? printed("%.2g", number).find('e') == std::string::npos && number >= 10
                              ? printed("%.0f", number) + " µs"
                              : printed("%.1f", number) + " µs"
                        : printed(number < 1e4 ? "%.2f" : "%.1f", number / 1000) + " ms";
  }
  const bool known = format.size() >= 3 && format[0] == '.' &&
                     format.find_first_not_of("0123456789", 1) == format.size() - 1;
  const std::string digits = known ? format.substr(0, format.size() - 1) : "";
  if (known && format.back() == '%') return printed(("%" + digits + "f %%").c_str(), 100 * number);
  if (known && (format.back() == 'f' || format.back() == 'g')) {
    const std::string text = printed(("%" + format).c_str(), number);
    return text.find_first_not_of("-0.") == std::string::npos && text[0] == '-' ? text.substr(1)
                                                                                : text;
  }
  throw InputError("\"" + format + "\" is not a format: .3f, .2g, .1%, d or us");
}

std::string formatted(const PageValue& value, const std::string& format) {
  if (value.numbers.empty()) return markdown_escaped(value.text);
  std::vector<std::string> shown;
  for (const auto& [label, number] : value.numbers) shown.push_back(formatted(number, format));
  if (value.text == "interval") return shown[0] + " (" + shown[1] + " to " + shown[2] + ")";
  return joined(shown, value.text == "range" ? " to " : ", ");
}

std::vector<std::string> words_of(std::string_view expression) {
  std::vector<std::string> words;
  std::string word;
  bool open = false;
  const auto end_word = [&] {
    if (!word.empty()) words.push_back(std::move(word));
    word.clear();
  };
  for (const char c : expression) {
    if (c == '\'') {
      open = !open;
    } else if (open) {
      word += c;
    } else if (c == '(' || c == ')') {
      end_word();
      words.emplace_back(1, c);
    } else if (c == ' ' || c == '\n') {
      end_word();
    } else {
      word += c;
    }
  }
  if (open) throw InputError("a quote is missing");
  end_word();
  return words;
}

}  // namespace ertbench
