#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// The one of `known` that `word` is likely to be a slip for (few letters differ, or it begins the
/// same); empty where none is near.
std::string nearest_word(std::string_view word, const std::vector<std::string>& known);

}  // namespace ertbench
