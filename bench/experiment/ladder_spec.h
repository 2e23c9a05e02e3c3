#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/score/frame_failure.h"
#include "core/json.h"
#include "forward/data/dataset_spec.h"

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

class JsonObject;
struct Experiment;
class SolverRegistry;
enum class SolverCheck;

/// One quantity that is made worse step by step, all others at their default.
struct LadderAxis {
  std::string name;   ///< of files and columns
  std::string title;  ///< for people
  std::string unit;   ///< empty where it has none
  /// JSON pointers to the places that are given the level's value. They lead into the test set's
  /// JSON; on an axis of a parameter into the solver's entry, or, where they begin with "train:",
  /// into the training set's JSON.
  std::vector<std::string> vary;
  std::vector<std::pair<std::string, JsonValue>>
      set;                    ///< other places, with their values at every level
  std::vector<Level> levels;  ///< from the mildest; numbers unless `categories`
  /// Labels of the solvers whose parameter it is, which are fitted anew at each level; empty for an
  /// axis of the scenes, which all solvers climb.
  std::vector<std::string> solvers;
  bool categories = false;   ///< levels without an order
  bool logarithmic = false;  ///< else linear
  bool integer = false;      ///< levels between two whole numbers are whole
  JsonValue spec;            ///< the axis as it stands in the file

  bool of_parameter() const { return !solvers.empty(); }
  bool concerns(const SolverEntry& entry) const;  ///< whether the entry's solver climbs this axis
};

/// The ladders of an experiment: how far each condition may worsen before a solver breaks down.
struct Ladders {
  std::string dataset;  ///< the test set that all levels are variants of
  JsonValue base;       ///< that test set as it stands in the experiment file
  JsonValue training;   ///< the training set as it stands there; null where there is none
  FailureRule failure;
  std::vector<LadderAxis> axes;
};

/// Reads `"ladders": {"dataset", "failure", "axes"}`; nothing where there is no such key. Datasets
/// and solvers of the experiment must be read already. Every level of an axis of the scenes is
/// checked as the dataset that it makes. Throws InputError.
std::optional<Ladders> read_ladders(JsonObject& root, const Experiment& experiment,
                                    SolverRegistry& registry, SolverCheck check);

/// The schema of "failure".
nlohmann::ordered_json ladder_settings_schema();

/// The test set at one level of an axis of the scenes. Its name, seed and count are the base set's,
/// so that its scenes, noise and faults are drawn alike. Throws InputError.
DatasetSpec dataset_at(const Ladders& ladders, const Sensor& sensor, const LadderAxis& axis,
                       const Level& level);

/// The solver's entry at one level of a parameter axis.
SolverEntry entry_at(const SolverEntry& entry, const LadderAxis& axis, const Level& level);
/// The training set there; nothing where the experiment has none.
std::optional<DatasetSpec> training_at(const Ladders& ladders, const Sensor& sensor,
                                       const LadderAxis& axis, const Level& level);

}  // namespace ertbench
