#include "bench/experiment/names.h"

#include <algorithm>
#include <cctype>

namespace ertbench {
namespace {

constexpr std::size_t longest = 60;

bool is_letter_or_digit(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

}  // namespace

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= longest &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return is_letter_or_digit(c) || c == '_' || c == '-'; });
}

bool is_label_text(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return is_letter_or_digit(c) || std::string_view(" ._+=,-").find(c) != std::string_view::npos;
  });
}

bool is_label(std::string_view text) {
  return !text.empty() && text.size() <= longest && is_label_text(text) && text.front() != '.' &&
         text.front() != ' ' && text.back() != ' ';
}

}  // namespace ertbench
