#include "bench/experiment/level.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/json_text.h"

namespace ertbench {
namespace {

std::string level_words(const nlohmann::json& value) {
  if (value.is_number()) {
    char text[32];
    std::snprintf(text, sizeof text, "%.5g", value.get<double>());
    return text;
  }
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return json_text(value);
  std::string out;
  for (const nlohmann::json& one : value) out += (out.empty() ? "" : ", ") + level_words(one);
  return out;
}

}  // namespace

Level::Level(double number) : value_(nlohmann::json(number)) {}

Level::Level(int number) : value_(nlohmann::json(number)) {}

Level::Level(nlohmann::json value) : value_(std::move(value)) {}

bool Level::is_number() const { return json().is_number(); }

double Level::number() const {
  if (!is_number()) throw std::logic_error("the level " + json_text(json()) + " is not a number");
  return json().get<double>();
}

std::string Level::text() const { return level_words(json()); }

}  // namespace ertbench
