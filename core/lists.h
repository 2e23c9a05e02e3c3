#pragma once

#include <algorithm>
#include <functional>
#include <ranges>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// True if the list has the value.
template <class List, class Value>
bool contains(const List& list, const Value& value) {
  return std::ranges::find(list, value) != std::ranges::end(list);
}

/// The different values of `of(item)`, in the order of their first items.
template <class List, class Of = std::identity>
auto distinct(const List& list, Of of = {}) {
  using Value = std::decay_t<std::invoke_result_t<Of, decltype(*std::begin(list))>>;
  std::vector<Value> out;
  for (const auto& item : list) {
    const Value& value = std::invoke(of, item);
    if (!contains(out, value)) out.push_back(value);
  }
  return out;
}

/// "a, b, c".
template <class Texts>
std::string joined(const Texts& texts, std::string_view between = ", ") {
  std::string out;
  for (const std::string& text : texts) {
    out.append(out.empty() ? "" : between).append(text);
  }
  return out;
}

}  // namespace ertbench
