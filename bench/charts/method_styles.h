#pragma once

#include <span>
#include <string>
#include <vector>

#include "bench/plot/style.h"

namespace ertbench {

/// How methods are told from each other, in colour, without it and in grey. A method of ertbench's
/// looks the same in every chart, whatever stands beside it; other labels take what is left.
class MethodStyles {
 public:
  /// `labels`: all in one chart. A label that is a method's name, or begins with it and a blank
  /// ("contacts disc"), has that method's hue; several of one method differ in shade, shape and
  /// dash.
  explicit MethodStyles(std::span<const std::string> labels);

  Colour colour(std::size_t label) const;
  LineStyle line(std::size_t label, double width = 1.3) const;
  /// Filled or hollow, so that more methods than there are shapes can be told apart in grey.
  MarkStyle mark(std::size_t label, double size = 0.75) const;
  /// Where the difference of the two means something.
  MarkStyle filled_mark(std::size_t label, double size = 0.75) const;
  MarkStyle hollow_mark(std::size_t label, double size = 0.75) const;

 private:
  struct Style {
    std::size_t place = 0;    ///< of the method, among all that can be told apart
    std::size_t variant = 0;  ///< of the labels of that method

    std::size_t shape() const { return place + variant; }
  };
  std::vector<Style> styles_;
};

/// Of things that have labels, in their order.
template <class Labelled>
MethodStyles styles_of(const std::vector<Labelled>& all) {
  std::vector<std::string> labels;
  for (const Labelled& one : all) labels.push_back(one.label);
  return MethodStyles(labels);
}

}  // namespace ertbench
