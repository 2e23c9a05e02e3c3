#include "solvers/tunable.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/json_text.h"
#include "core/text.h"

namespace ertbench {

Tunable read_tunable(JsonObject& object, std::string_view key, Range range, bool whole) {
  const std::string source = object.source().empty() ? "" : object.source() + ": ";
  Tunable tunable{std::nullopt, source + object.path_of(key)};
  if (!object.has(key)) return tunable;
  const nlohmann::json& value = object.raw(key);
  if (value.is_string() && value.get_ref<const std::string&>() == "auto") return tunable;
  const bool usable = value.is_number() && range.contains(value.get<double>()) &&
                      (!whole || value.get<double>() == std::floor(value.get<double>()));
  if (!usable) {
    object.fail(key, (whole ? "must be a whole number, " : "") + range.text() +
                         " or \"auto\", got " + json_shown(value));
  }
  tunable.value = value.get<double>();
  return tunable;
}

Tunable read_weight(JsonObject& object, std::string_view key) {
  constexpr Range weights{1e-20, 1e20};
  Tunable tunable = read_tunable(object, key, Range::positive());
  if (tunable.value && !weights.contains(*tunable.value)) {
    object.fail(key, weights.text() + " or \"auto\", got " + number_text(*tunable.value));
  }
  return tunable;
}

}  // namespace ertbench
