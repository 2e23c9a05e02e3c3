#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/score/frame_failure.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

class JsonObject;
struct Experiment;
class SolverRegistry;
enum class SolverCheck;

/// One quantity that is made worse step by step, all others at their default.
struct LadderAxis {
  std::string name;   ///< of files and columns
  std::string title;  ///< for people
  std::string unit;   ///< empty where it has none
  /// JSON pointers, all given the level's value: into the test set's JSON; of a parameter axis into
  /// the solver's entry, or behind "train:" into the training set's.
  std::vector<std::string> vary;
  std::vector<std::pair<std::string, std::string>> set;  ///< pointers and JSON texts, likewise
  std::vector<std::string> levels;  ///< JSON texts, from the mildest; numbers unless `categories`
  /// Labels of the solvers whose parameter it is, which are fitted anew at each level; empty for an
  /// axis of the scenes, which all solvers climb.
  std::vector<std::string> solvers;
  bool categories = false;   ///< levels without an order
  bool logarithmic = false;  ///< else linear
  bool integer = false;      ///< levels between two whole numbers are whole
  std::string json;          ///< the axis as it stands in the file

  bool of_parameter() const { return !solvers.empty(); }
  bool concerns(const SolverEntry& entry) const;  ///< whether its solver climbs it
};

/// The ladders of an experiment: how far each condition may worsen before a solver breaks down.
struct Ladders {
  std::string dataset;        ///< the test set that all levels are variants of
  std::string dataset_json;   ///< its JSON in the experiment file
  std::string training_json;  ///< that of the training set; empty where there is none
  FailureRule failure;
  std::vector<LadderAxis> axes;
};

/// Reads `"ladders": {"dataset", "failure", "axes"}`; nothing where there is no such key. Datasets
/// and solvers of the experiment must be read already. Every level of an axis of the scenes is
/// checked as the dataset that it makes. Throws InputError.
std::optional<Ladders> read_ladders(JsonObject& root, const Experiment& experiment,
                                    SolverRegistry& registry, SolverCheck check);

/// The test set at one level (JSON text) of an axis of the scenes. Its name, seed and count are the
/// base set's, so that its scenes, noise and faults are drawn alike. Throws InputError.
DatasetSpec dataset_at(const Experiment& experiment, const LadderAxis& axis,
                       const std::string& level);

/// The solver's entry at one level of a parameter axis.
SolverEntry entry_at(const SolverEntry& entry, const LadderAxis& axis, const std::string& level);
/// The training set there; nothing where the experiment has none.
std::optional<DatasetSpec> training_at(const Experiment& experiment, const LadderAxis& axis,
                                       const std::string& level);

/// A level for people: "40", "0.06", "ring".
std::string level_text(const std::string& level);

}  // namespace ertbench
