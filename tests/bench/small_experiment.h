#pragma once

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tests/bench/program.h"

namespace ertbench::testing {

/// Three quick solvers on 40 frames; timing off unless asked for.
inline nlohmann::json small_experiment() {
  return nlohmann::json::parse(R"({
    "datasets": {
      "validation": {"count": 30, "seed": 2, "snr_db": 50, "snr_basis": "absolute", "scenes": {}},
      "test": {"count": 40, "seed": 3, "snr_db": 50, "snr_basis": "absolute",
               "scenes": {"contacts": 1, "shapes": ["disc"], "radius": 0.2, "conductivity_ratio": 0.6}}
    },
    "solvers": [{"type": "one-step-gn", "lambda": "auto"}, {"type": "tsvd", "rank": 30},
                {"type": "pdipm", "alpha": 1e-6}],
    "timing": {"enabled": false},
    "figure": {"scenes": [0, 1]}
  })");
}

inline nlohmann::json summary_of(const fs::path& results) {
  return nlohmann::json::parse(read_text(results / "summary.json"));
}

inline const nlohmann::json& row_of(const nlohmann::json& summary, const std::string& label) {
  for (const nlohmann::json& row : summary.at("rows")) {
    if (row.at("label") == label) return row;
  }
  throw std::runtime_error("no row " + label);
}

}  // namespace ertbench::testing
