#include "core/nearest_word.h"

#include <algorithm>
#include <numeric>

namespace ertbench {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// Whether the unknown word is likely to be a slip for the known one.
bool is_slip(std::string_view word, std::string_view known) {
  const auto end = std::mismatch(word.begin(), word.end(), known.begin(), known.end()).first;
  const auto common = static_cast<std::size_t>(end - word.begin());
  return edit_distance(word, known) <= std::max<std::size_t>(2, word.size() / 3) ||
         (common >= 4 && 2 * common >= word.size());
}

}  // namespace

std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  const auto nearest =
      std::min_element(known.begin(), known.end(), [&](const std::string& a, const std::string& b) {
        return edit_distance(word, a) < edit_distance(word, b);
      });
  return nearest != known.end() && is_slip(word, *nearest) ? *nearest : "";
}

}  // namespace ertbench
