#pragma once

#include <string>
#include <vector>

#include "core/json_value.h"

namespace ertbench {

class JsonObject;
struct SolverInfo;

/// One combination of the values of a sweep.
struct SweepPoint {
  std::string label;  ///< " alpha=0.001 beta=0.1", to stand behind the entry's own; "" for none
  JsonValue values;   ///< `{"alpha": 0.001, "beta": 0.1}`; null for none
  std::vector<std::size_t> indices;  ///< of the values in their lists, parameter by parameter
};

/// Reads `"sweep": {"alpha": [1e-4, 1e-3], "beta": [0.1, 1]}` of a solver's entry: one or two of
/// the solver's parameters (in alphabetical order, as the keys of JSON have none), each with 1 to
/// 50 different values: numbers, strings, true or false, lists of numbers. Returns every
/// combination, the last parameter changing fastest; without a sweep one point without values.
/// `info` may be null for a solver whose parameters are not known here. Throws InputError.
std::vector<SweepPoint> read_sweep(JsonObject& entry, const SolverInfo* info);

}  // namespace ertbench
