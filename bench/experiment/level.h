#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/json_value.h"

namespace ertbench {

/// A level of a ladder: what the test set, or the solver, is given in the varied place. Most are
/// numbers; levels without an order may be texts, lists or objects.
class Level {
 public:
  Level() = default;     ///< null: the test set as it is
  Level(double number);  // implicit: most levels are numbers
  Level(int number);
  Level(nlohmann::json value);  // implicit: what stands in the file is the level

  bool is_number() const;
  double number() const;     ///< Throws std::logic_error where the level is none.
  std::string text() const;  ///< for people: "40", "0.06", "ring", "disc, ring"
  const nlohmann::json& json() const { return *value_; }

  friend bool operator==(const Level&, const Level&) = default;

 private:
  JsonValue value_;
};

}  // namespace ertbench
