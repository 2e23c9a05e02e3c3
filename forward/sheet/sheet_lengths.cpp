#include <nlohmann/json.hpp>

#include "core/text.h"
#include "forward/sheet/sensor_json.h"

namespace ertbench {
namespace {

std::string in_mm(const char* key) { return std::string(key) + "_mm"; }

}  // namespace

Range SheetLengths::Form::range(Range domain) const {
  return {unit * domain.low, unit * domain.high, domain.low_open, unit_name};
}

bool SheetLengths::has(const char* key) const {
  const bool domain = object_.has(key);  // both are known keys, whichever of them stands there
  return object_.has(in_mm(key)) || domain;
}

SheetLengths::Form SheetLengths::form_of(const char* key) const {
  const bool domain = object_.has(key);
  const bool millimetres = object_.has(in_mm(key));
  if (domain && millimetres) {
    object_.fail(in_mm(key), "stands beside \"" + std::string(key) +
                                 "\", which says the same in domain units; remove one of the two");
  }
  if (millimetres) return {in_mm(key), sheet_.unit_mm(), sheet_.bounds().center(), "mm"};
  return {key, 1, Eigen::Vector2d::Zero(), ""};
}

double SheetLengths::length(const char* key, Range range) {
  const Form form = form_of(key);
  return object_.number(form.key, form.range(range)) / form.unit;
}

Eigen::Vector2d SheetLengths::lengths(const char* key, Range range) {
  const Form form = form_of(key);
  const std::vector<double> two = object_.numbers(form.key, 2, form.range(range));
  return Eigen::Vector2d(two[0], two[1]) / form.unit;
}

std::vector<double> SheetLengths::numbers(const char* key, std::size_t least, std::size_t most,
                                          Range range) {
  const Form form = form_of(key);
  const std::size_t size = object_.raw(form.key).size();
  if (size < least || size > most) {
    object_.fail(form.key, "must be a list of " + std::to_string(least) + " to " +
                               std::to_string(most) + " numbers, holds " + std::to_string(size));
  }
  std::vector<double> out = object_.numbers(form.key, size, form.range(range));
  for (double& number : out) number /= form.unit;
  return out;
}

std::pair<double, double> SheetLengths::length_interval(const char* key, Range range) {
  const Form form = form_of(key);
  const auto [low, high] = object_.interval(form.key, form.range(range));
  return {low / form.unit, high / form.unit};
}

Eigen::Vector2d SheetLengths::place(const char* key, Range range) {
  return form_of(key).origin + lengths(key, range);
}

std::vector<Eigen::Vector2d> SheetLengths::places(const char* key, std::size_t least,
                                                  std::size_t most, Range range) {
  const Form form = form_of(key);
  std::vector<Eigen::Vector2d> out;
  for (const auto& [x, y] : object_.points(form.key, least, most, form.range(range))) {
    out.emplace_back(form.origin + Eigen::Vector2d(x, y) / form.unit);
  }
  return out;
}

std::pair<double, double> SheetLengths::coordinate_interval(const char* key, int axis,
                                                            Range range) {
  const double origin = form_of(key).origin[axis];
  range.low -= origin;
  range.high -= origin;
  const auto [low, high] = length_interval(key, range);
  return {origin + low, origin + high};
}

void SheetLengths::fail(const char* key, const std::string& message) const {
  object_.fail(form_of(key).key, message);
}

std::string SheetLengths::shown(const char* key, double length) const {
  const Form form = form_of(key);
  return number_text(form.unit * length) + (*form.unit_name ? " " : "") + form.unit_name;
}

}  // namespace ertbench
