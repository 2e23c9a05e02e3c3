#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/json_reader.h"

namespace ertbench {

/// A parameter that is a number, or "auto": chosen on the validation set.
struct Tunable {
  std::optional<double> value;  ///< none: "auto"
  std::string place;            ///< where it stands, for messages: "a.json: /solvers/2/lambda"

  bool automatic() const { return !value.has_value(); }
};

/// Reads `key`, "auto" where it is absent. Throws InputError unless it is "auto" or a number in
/// `range` (and whole where `whole`).
Tunable read_tunable(JsonObject& object, std::string_view key, Range range, bool whole = false);

/// The same for the weight of a prior, a number > 0 whose square and the inverse of that a computer
/// can hold: from 1e-20 to 1e20.
Tunable read_weight(JsonObject& object, std::string_view key);

}  // namespace ertbench
