#include "bench/report/chart.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>

namespace ertbench {

std::string chart_status(const ResultRow* row) {
  if (!row) return "not run";
  return row->ok() ? "" : row->status;
}

namespace {

/// Each hue comes again in a darker shade, which is told apart in grey too.
constexpr std::size_t places = 2 * hues;

/// The place of a method is its index.
constexpr std::array<std::string_view, 12> methods = {
    "one-step-gn", "tsvd", "pdipm",  "lmmse",  "gauss-newton", "contacts",
    "fcnn",        "dcnn", "eit-nn", "dd-ert", "lean-net",     "kernel-ridge"};
static_assert(methods.size() <= places);

std::optional<std::size_t> method_of(std::string_view label) {
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const std::string_view name = methods[i];
    if (label.starts_with(name) && (label.size() == name.size() || label[name.size()] == ' '))
      return i;
  }
  return std::nullopt;
}

}  // namespace

MethodStyles::MethodStyles(std::span<const std::string> labels) {
  std::array<bool, places> taken{};
  for (const std::string& label : labels) {
    if (const auto method = method_of(label)) taken[*method] = true;
  }
  std::map<std::size_t, std::size_t> variants;  // by place
  std::size_t others = 0;
  for (const std::string& label : labels) {
    std::size_t place = 0;
    if (const auto method = method_of(label)) {
      place = *method;
    } else {
      const auto free = std::ranges::find(taken, false);
      place =
          free == taken.end() ? others++ % places : static_cast<std::size_t>(free - taken.begin());
      taken[place] = true;
    }
    styles_.push_back({place, variants[place]++});
  }
}

Colour MethodStyles::colour(std::size_t label) const {
  const auto [place, variant] = styles_[label];
  constexpr double shifts[] = {0, 0.3, 0.55, 0.15, 0.42};  // no variant as dark as the black one
  const double shift = shifts[variant % std::size(shifts)];
  if (place < hues) return hue(place).towards_black(shift);
  return hue(place).towards_black(0.45).towards_white(shift);
}

LineStyle MethodStyles::line(std::size_t label, double width) const {
  constexpr int dashes[] = {1, 2, 4, 5, 3};
  return {colour(label), width, dashes[styles_[label].shape() % std::size(dashes)]};
}

MarkStyle MethodStyles::mark(std::size_t label, double size) const {
  const bool again = styles_[label].shape() / std::size(shapes) % 2 == 1;
  return again ? hollow_mark(label, size) : filled_mark(label, size);
}

MarkStyle MethodStyles::filled_mark(std::size_t label, double size) const {
  return {filled(styles_[label].shape()), colour(label), size, 1.2};
}

MarkStyle MethodStyles::hollow_mark(std::size_t label, double size) const {
  return {hollow(styles_[label].shape()), colour(label), size, 1.2};
}

}  // namespace ertbench
