#include "bench/plot/category_names.h"

#include <algorithm>
#include <utility>

#include "core/text.h"

namespace ertbench {
namespace {

constexpr double gap_below = 6;  ///< below the panel, px

bool fits(const std::string& name, double slot, int size) {
  constexpr std::size_t most_lines = 4;
  return widest_word(name, size) <= slot &&
         wrapped(name, characters_in(slot, size)).size() <= most_lines;
}

}  // namespace

double widest_word(const std::string& text, int size) {
  double widest = 0;
  std::string word;
  for (const char c : text + " ") {
    if (c != ' ') word += c;
    if (c != ' ' && c != '-' && c != '_') continue;
    widest = std::max(widest, text_width(word, size));
    word.clear();
  }
  return widest;
}

CategoryNames::CategoryNames(std::vector<std::string> names, double slot, int size)
    : names_(std::move(names)), slot_(slot), size_(size) {
  upright_ = std::any_of(names_.begin(), names_.end(),
                         [&](const std::string& name) { return !fits(name, slot_, size_); });
}

double CategoryNames::height() const {
  double most = 0;
  for (const std::string& name : names_) {
    const auto lines = static_cast<double>(wrapped(name, characters_in(slot_, size_)).size());
    most = std::max(most, upright_ ? text_width(name, size_) : lines * (size_ + 2));
  }
  return gap_below + most;
}

void CategoryNames::draw(Canvas& canvas, double left, double bottom) const {
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const double x = left + (static_cast<double>(i) + 0.5) * slot_;
    if (upright_) {
      canvas.text(names_[i], x, bottom + gap_below,
                  {.size = size_, .align = TextAlign::right, .upright = true});
    } else {
      canvas.lines(names_[i], characters_in(slot_, size_), x, bottom + gap_below + size_ / 2.0,
                   {.size = size_});
    }
  }
}

}  // namespace ertbench
