#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "forward/data/dataset_spec.h"

namespace ertbench {

struct Experiment;

/// A study of touches beyond the scores of single images, one of the questions of the paper's
/// appendix D. It evaluates the contacts that the solvers detect in the named test sets, or (the
/// type "arm_hour") in frames of its own.
struct StudySpec {
  std::string type;                          ///< of study_types(): "localisation", "arm_hour"
  std::string name;                          ///< names its files and its part of summary.json
  std::vector<std::string> sets;             ///< "sets": test sets of the kind that it needs
  std::vector<std::string> maps;             ///< sets for which a map is drawn
  std::map<std::string, std::string> roles;  ///< test sets with a special role, by its key
  std::map<std::string, double> numbers;     ///< all its numbers, defaults included

  double number(const std::string& key) const { return numbers.at(key); }
};

/// Reads `"studies": [{"type", "name", ...}]`, none without the key. The datasets of the experiment
/// must have been read. Throws InputError.
std::vector<StudySpec> read_studies(JsonObject& root, const Experiment& experiment);

/// Cross-validation on measured frames: every solver is fitted for each fold and each number of
/// presses, and tested on the held-out share of the fold. With several skins each has `count` folds
/// of its own: fold f is fold f % count of skin f / count.
struct Folds {
  /// The sets whose rows are divided: the training set, or one for each of "skins".
  std::vector<DatasetSpec> skins;
  int count = 5;                       ///< number of folds of a skin
  std::vector<std::uint64_t> presses;  ///< numbers of presses to learn from, ascending
  double validation = 0.2;             ///< share of the presses for validation
  std::uint64_t seed = 1;              ///< of the order of the rows

  /// The first rows of the fold's shuffled rest, so that fewer presses are a subset of more.
  /// Training and validation set together have `number` presses.
  int total() const { return count * static_cast<int>(skins.size()); }
  const DatasetSpec& skin_of(int fold) const {
    return skins.at(static_cast<std::size_t>(fold / count));
  }
  /// The most presses of a skin that every fold leaves to learn from.
  std::uint64_t most(const DatasetSpec& skin) const;
  DatasetSpec training(int fold, std::uint64_t number) const;
  DatasetSpec validation_set(int fold, std::uint64_t number) const;
  DatasetSpec test(int fold) const;

 private:
  std::uint64_t validation_count(std::uint64_t number) const;
  DatasetSpec part(const char* name, const DatasetSpec& skin, const FoldPart& fold) const;
};

/// Reads `"folds": {"count", "presses", "validation", "rows" or "skins", "seed"}`, none without the
/// key. The training set must have been read and hold measured frames with known positions. Throws
/// InputError.
std::optional<Folds> read_folds(JsonObject& root, const Experiment& experiment);

/// Part of the keys of records.
nlohmann::json to_json(const Folds& folds);

}  // namespace ertbench
