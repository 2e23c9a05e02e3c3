#pragma once

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

/// A level of a ladder: the value at the varied place of the test set or the solver. Most levels
/// are numbers; levels without an order may be strings, lists or objects.
class Level {
 public:
  Level() = default;     ///< null: the test set as it is
  Level(double number);  // implicit: most levels are numbers
  Level(int number);
  Level(nlohmann::json value);  // implicit

  bool is_number() const;
  double number() const;     ///< Throws std::logic_error if the level is not a number.
  std::string text() const;  ///< for people: "40", "0.06", "ring", "disc, ring"
  const nlohmann::json& json() const { return *value_; }

  friend bool operator==(const Level&, const Level&) = default;

 private:
  JsonValue value_;
};

struct Experiment;
class SolverRegistry;
enum class SolverCheck;

/// One quantity that worsens level by level, with all others at their default.
struct LadderAxis {
  std::string name;   ///< of files and columns
  std::string title;  ///< for people
  std::string unit;   ///< empty for none
  /// JSON pointers to the places that get the level's value: in the JSON of the test set; on an
  /// axis of a parameter in the solver's entry or, after "train:", in the JSON of the training set.
  std::vector<std::string> vary;
  /// Places that get a value of their own at each level, for conditions that worsen together:
  /// [places] the pointer and its values [levels]. The levels, categories, are only names.
  std::vector<std::pair<std::string, JsonValue>> together;
  std::vector<std::pair<std::string, JsonValue>>
      set;                    ///< other places, with their values at every level
  std::vector<Level> levels;  ///< from the mildest on; numbers unless `categories`
  /// Labels of the solvers whose parameter varies, which are fitted at each level; empty for an
  /// axis of the scenes, which all solvers climb.
  std::vector<std::string> solvers;
  bool categories = false;   ///< levels without an order
  bool logarithmic = false;  ///< else linear
  bool integer = false;      ///< only whole numbers lie between two levels
  JsonValue spec;            ///< the axis as written in the file

  bool of_parameter() const { return !solvers.empty(); }
  bool concerns(const SolverEntry& entry) const;  ///< whether the entry's solver climbs this axis
};

/// The ladders of an experiment: how far each condition may worsen before a solver fails.
struct Ladders {
  std::string dataset;  ///< the test set that all levels are variants of
  JsonValue base;       ///< that test set as written in the experiment file
  JsonValue training;   ///< the training set as written there; null for none
  FailureRule failure;
  std::vector<LadderAxis> axes;
};

/// Reads `"ladders": {"dataset", "failure", "axes"}`, nothing without the key. Datasets and solvers
/// of the experiment must have been read. Checks the dataset of every level. Throws InputError.
std::optional<Ladders> read_ladders(JsonObject& root, const Experiment& experiment,
                                    SolverRegistry& registry, SolverCheck check);

/// The schema of "failure".
nlohmann::ordered_json ladder_settings_schema();

/// The test set at one level of an axis of the scenes. It has the name, seed and count of the base
/// set, so that scenes, noise and faults are drawn alike. Throws InputError.
DatasetSpec dataset_at(const Ladders& ladders, const Sensor& sensor, const LadderAxis& axis,
                       const Level& level);

/// The solver's entry at one level of a parameter axis.
SolverEntry entry_at(const SolverEntry& entry, const LadderAxis& axis, const Level& level);
/// The training set at one level; nothing if the experiment has none.
std::optional<DatasetSpec> training_at(const Ladders& ladders, const Sensor& sensor,
                                       const LadderAxis& axis, const Level& level);

}  // namespace ertbench
