#include "bench/pages/page_expression.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

using nlohmann::json;
using Numbers = std::vector<std::pair<std::string, double>>;

PageValue of(double number) { return {{{"", number}}, ""}; }

PageValue of_text(std::string text) { return {{}, std::move(text)}; }

Numbers all_of(const std::vector<PageValue>& arguments) {
  Numbers out;
  for (const PageValue& argument : arguments) {
    out.insert(out.end(), argument.numbers.begin(), argument.numbers.end());
  }
  if (out.empty()) throw InputError("there is no number to take");
  return out;
}

std::vector<double> values_of(const Numbers& numbers) {
  std::vector<double> out;
  for (const auto& [label, value] : numbers) out.push_back(value);
  return out;
}

const std::pair<std::string, double>& extreme(const Numbers& numbers, bool least) {
  return *std::min_element(numbers.begin(), numbers.end(), [&](const auto& a, const auto& b) {
    return least ? a.second < b.second : a.second > b.second;
  });
}

bool every_pair(const PageValue& a, const PageValue& b,
                const std::function<bool(double, double)>& compare) {
  if (a.numbers.empty() || b.numbers.empty()) throw InputError("there is nothing to compare");
  return std::all_of(a.numbers.begin(), a.numbers.end(), [&](const auto& x) {
    return std::all_of(b.numbers.begin(), b.numbers.end(),
                       [&](const auto& y) { return compare(x.second, y.second); });
  });
}

using Arguments = std::vector<PageValue>;
using Operation = std::function<PageValue(const Arguments&)>;

Operation arithmetic(double (*combine)(double, double)) {
  return [combine](const Arguments& a) {
    double out = a.at(0).number();
    for (std::size_t i = 1; i < a.size(); ++i) out = combine(out, a[i].number());
    return of(out);
  };
}

Operation comparison(bool (*compare)(double, double)) {
  return [compare](const Arguments& a) { return of(every_pair(a.at(0), a.at(1), compare)); };
}

Operation statistic(double (*of_all)(const Numbers&)) {
  return [of_all](const Arguments& a) { return of(of_all(all_of(a))); };
}

double sum_of(const Numbers& numbers) {
  double sum = 0;
  for (const auto& [label, value] : numbers) sum += value;
  return sum;
}

double difference(double a, double b) { return a - b; }
double quotient(double a, double b) { return a / b; }

const std::map<std::string, Operation>& operations() {
  static const std::map<std::string, Operation> all = {
      {"+", arithmetic([](double a, double b) { return a + b; })},
      {"*", arithmetic([](double a, double b) { return a * b; })},
      {"-", arithmetic(difference)},
      {"difference", arithmetic(difference)},
      {"/", arithmetic(quotient)},
      {"ratio", arithmetic(quotient)},
      {"abs",
       [](const Arguments& a) {
         PageValue out = a.at(0);
         for (auto& [label, value] : out.numbers) value = std::abs(value);
         return out;
       }},
      {"less",  // of each number less the second argument
       [](const Arguments& a) {
         PageValue out = a.at(0);
         for (auto& [label, value] : out.numbers) value -= a.at(1).number();
         return out;
       }},
      {"min", statistic([](const Numbers& n) { return extreme(n, true).second; })},
      {"max", statistic([](const Numbers& n) { return extreme(n, false).second; })},
      {"sum", statistic(sum_of)},
      {"mean",
       statistic([](const Numbers& n) { return sum_of(n) / static_cast<double>(n.size()); })},
      {"median", statistic([](const Numbers& n) { return median(values_of(n)); })},
      {"count",
       [](const Arguments& a) {
         double count = 0;
         for (const PageValue& one : a) count += static_cast<double>(one.numbers.size());
         return of(count);
       }},
      {"range",
       [](const Arguments& a) {
         const Numbers all = all_of(a);
         return PageValue{{extreme(all, true), extreme(all, false)}, "range"};
       }},
      {"best", [](const Arguments& a) { return of_text(extreme(all_of(a), true).first); }},
      {"worst", [](const Arguments& a) { return of_text(extreme(all_of(a), false).first); }},
      {"<", comparison([](double a, double b) { return a < b; })},
      {"<=", comparison([](double a, double b) { return a <= b; })},
      {">", comparison([](double a, double b) { return a > b; })},
      {">=", comparison([](double a, double b) { return a >= b; })},
      {"=",
       [](const Arguments& a) {
         const double tolerance = a.size() > 2 ? a[2].number() : 0;
         return of(every_pair(a.at(0), a.at(1),
                              [&](double x, double y) { return std::abs(x - y) <= tolerance; }));
       }},
      {"order",
       [](const Arguments& a) {
         bool in_order = true;
         for (std::size_t i = 1; i < a.size(); ++i) {
           in_order =
               in_order && every_pair(a[i - 1], a[i], [](double x, double y) { return x < y; });
         }
         return of(in_order);
       }},
      {"and",
       [](const Arguments& a) {
         return of(std::all_of(a.begin(), a.end(), [](const auto& x) { return x.number() != 0; }));
       }},
      {"or",
       [](const Arguments& a) {
         return of(std::any_of(a.begin(), a.end(), [](const auto& x) { return x.number() != 0; }));
       }},
      {"not", [](const Arguments& a) { return of(a.at(0).number() == 0); }},
      {"is", [](const Arguments& a) { return of(a.at(0).text == a.at(1).text); }},
  };
  return all;
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
    const std::string selection = take();
    const std::string column = take();
    PageValue out;
    for (const json* row : results_.select(file, selection, column)) {
      const json& value = value_in(*row, column);
      if (value.is_number()) out.numbers.emplace_back(label_of(*row), value.get<double>());
      if (value.is_string()) out.text = value.get<std::string>();
    }
    if (out.numbers.empty() && out.text.empty() &&
        selection.find_first_of("<>!") == std::string::npos) {
      throw InputError("no " + column + " in the rows \"" + selection + "\" of " + file);
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
  std::string out;
  const bool range = value.text == "range";
  for (const auto& [label, number] : value.numbers) {
    out += (out.empty() ? "" : range ? " to " : ", ") + formatted(number, format);
  }
  return out;
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
