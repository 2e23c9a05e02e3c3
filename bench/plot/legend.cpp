#include "bench/plot/legend.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace ertbench {
namespace {

constexpr int size = 10;
constexpr double entry_gap = 16;  ///< between two entries, px

/// Of what stands before the text, px.
double sample_width(const LegendEntry& entry) {
  if (entry.line) return entry.mark && entry.line->dash > 1 ? 46 : 34;
  if (entry.mark || entry.fill) return 13;
  return 0;
}

double text_left(const LegendEntry& entry) {
  const double sample = sample_width(entry);
  return sample > 0 ? sample + 6 : 0;
}

}  // namespace

Legend::Legend(double left, double right, std::optional<int> columns)
    : left_(left), right_(right), columns_(columns) {}

void Legend::add(LegendEntry entry) {
  double width = text_left(entry) + text_width(entry.text, size) + entry_gap;
  if (columns_) {
    const double column = (right_ - left_) / *columns_;
    const double taken = std::ceil((width - entry_gap + 4) / column);
    width = column * std::clamp<double>(taken, 1, *columns_);
    entry.text = one_line(entry.text, characters_in(width - text_left(entry) - 4, size));
  }
  const bool fits = left_ + next_ + width <= right_ + (columns_ ? 1 : entry_gap);
  if (next_ > 0 && (broken_ || !fits)) {
    next_ = 0;
    ++line_;
  }
  broken_ = false;
  entries_.push_back({std::move(entry), left_ + next_, line_});
  next_ += width;
}

void Legend::draw(Canvas& canvas, double top) const {
  for (const Place& place : entries_) {
    const LegendEntry& entry = place.entry;
    const double y = top + line_height * place.line;
    const double sample = sample_width(entry);
    if (entry.line && entry.mark) {  // from the mark on, so that both sides show the same dashes
      canvas.line(place.left + sample / 2, y, place.left, y, *entry.line);
      canvas.line(place.left + sample / 2, y, place.left + sample, y, *entry.line);
    } else if (entry.line) {
      canvas.line(place.left, y, place.left + sample, y, *entry.line);
    }
    if (entry.fill)
      canvas.rectangle({place.left, y - 5, place.left + 12, y + 5}, {.fill = entry.fill});
    if (entry.mark) canvas.mark(place.left + sample / 2, y, *entry.mark);
    canvas.text(entry.text, place.left + text_left(entry), y,
                {.size = size, .align = TextAlign::left});
  }
}

}  // namespace ertbench
