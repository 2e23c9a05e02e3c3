#pragma once

#include <algorithm>
#include <functional>
#include <ranges>
#include <string>
#include <string_view>
#include <type_traits>
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

/// "a, b, c": the texts or whole numbers `of(item)`.
template <class List, class Of = std::identity>
std::string joined(const List& list, std::string_view between = ", ", Of of = {}) {
  std::string out;
  for (const auto& item : list) {
    const auto& value = std::invoke(of, item);
    out.append(out.empty() ? "" : between);
    if constexpr (std::is_integral_v<std::decay_t<decltype(value)>>) {
      out += std::to_string(value);
    } else {
      out += value;
    }
  }
  return out;
}

}  // namespace ertbench
