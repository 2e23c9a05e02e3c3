#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ertbench {

/// One solver to be fitted and scored: an entry of "solvers", or one of the many that an entry with
/// "seeds" or a "sweep" stands for. Those of one label make one row.
struct SolverEntry {
  std::string label;        ///< of its row; what differs by the seed alone shares it
  std::string type;         ///< "dd-ert"
  std::string json;         ///< JSON text the solver is made from: no "seeds" and no "sweep"
  std::string path;         ///< "/solvers/2", for messages
  std::optional<int> seed;  ///< where the entry has "seeds"
  /// What rows that differ by a setting share: "family", else the label without a sweep's values.
  std::string family;
  std::string sweep_json;  ///< JSON text of those, `{"alpha": 0.001}`; empty without a sweep
  /// What the registration of its type says (`describe`); nothing while the plugin of the type is
  /// not loaded.
  std::vector<std::string> inference_parameters;  ///< that have no part in the fit
  bool break_even_reference = false;              ///< what longer fits are held against by default

  /// Unique in the experiment, for file names: "dd-ert", "dd-ert.seed2".
  std::string stem() const { return seed ? label + ".seed" + std::to_string(*seed) : label; }
  /// The same for people: "dd-ert seed 2".
  std::string title() const { return seed ? label + " seed " + std::to_string(*seed) : label; }
};

}  // namespace ertbench
