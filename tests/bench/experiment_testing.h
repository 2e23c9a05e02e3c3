#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/line_process.h"

/// What the tests of experiment files share.
namespace ertbench::testing {

using nlohmann::json;

inline const std::filesystem::path experiments = ERTBENCH_SOURCE_DIR "/experiments";

/// The published schema's validator, which lives as long as the tests.
inline std::string schema_complaint(const json& value) {
  static LineProcess validator({"/usr/bin/python3",
                                ERTBENCH_SOURCE_DIR "/tests/bench/validate_schema.py",
                                (experiments / "schema.json").string()});
  return validator.answer(value.dump());
}

inline std::string refusal(const std::filesystem::path& file) {
  SolverRegistry registry;
  try {
    read_experiment(file, registry, chart_types());
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

/// A small experiment that is right.
inline json good() {
  return json::parse(R"({
    "title": "t", "question": "q",
    "sensor": {"electrode_count": 16},
    "datasets": {
      "validation": {"count": 10, "seed": 2, "grid": 24, "snr_db": 50, "snr_basis": "absolute",
                     "scenes": {"contacts": [1, 3], "radius": [0.1, 0.3]}},
      "test": {"snr_db": null, "scenes": [{"contacts": [
          {"shape": "disc", "centre": [0, 0], "radius": 0.2, "conductivity_ratio": 0.6}]}]}
    },
    "solvers": [{"type": "tsvd", "rank": 20}, {"type": "one-step-gn", "lambda": "auto"},
                {"type": "pdipm", "alpha": 1e-4}],
    "timing": {"frames": 700, "batch": 16},
    "figure": {"scenes": [0]},
    "published": {"source": "s", "rows": {"tsvd": {"AR": 1.2}}}
  })");
}

/// The good experiment with a toy network for its first solver.
inline json learned(const json& more) {
  json value = good();
  value["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  value["solvers"][0] = {{"type", "toy-learned"}, {"label", "net"}};
  value["solvers"][0].update(more);
  return value;
}

}  // namespace ertbench::testing
