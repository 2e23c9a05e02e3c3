#pragma once

#include <string>

namespace ertbench {

/// When records were made. Dates are ISO 8601 in UTC, so that their order is that of the text.
struct DateRange {
  std::string first;  ///< empty where there are none
  std::string last;

  void add(const std::string& date) {
    if (date.empty()) return;
    if (first.empty() || date < first) first = date;
    if (last.empty() || date > last) last = date;
  }
};

}  // namespace ertbench
