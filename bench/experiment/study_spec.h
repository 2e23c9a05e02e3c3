#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "forward/data/dataset_spec.h"

namespace ertbench {

class JsonObject;
struct Experiment;

/// What an experiment asks of touches beyond the scores of single images: one of the questions of
/// the paper's appendix D. It reads what the solvers found in the frames of the named test sets.
struct StudySpec {
  std::string
      type;  ///< "localisation", "sensitivity", "targets", "tracking", "collision", "consistency"
  std::string name;                          ///< of its files and of its part of summary.json
  std::vector<std::string> sets;             ///< "sets": test sets, all of the kind that it needs
  std::vector<std::string> maps;             ///< of these sets, each of which has a map drawn
  std::map<std::string, std::string> roles;  ///< test sets with a part of their own, by its key
  std::map<std::string, double> numbers;     ///< all there are, with their defaults

  double number(const std::string& key) const { return numbers.at(key); }
};

/// Reads `"studies": [{"type", "name", ...}]`; none where there is no such key. Datasets of the
/// experiment must be read already. Throws InputError.
std::vector<StudySpec> read_studies(JsonObject& root, const Experiment& experiment);

class JsonObject;
struct Experiment;

/// Cross-validation on measured frames: every solver is fitted anew for each fold and each number
/// of presses, and tried on the share of the fold that none of them has seen.
struct Folds {
  DatasetSpec base;                    ///< whose rows are divided: the training set's file
  int count = 5;                       ///< of folds
  std::vector<std::uint64_t> presses;  ///< that are learned from, ascending
  double validation = 0.2;             ///< share of them that is the validation set
  std::uint64_t seed = 1;              ///< of the rows' order

  /// What is learned from: the first of the fold's shuffled rest, so that fewer presses are a part
  /// of more. Together with the validation set these are `number` presses.
  DatasetSpec training(int fold, std::uint64_t number) const;
  DatasetSpec validation_set(int fold, std::uint64_t number) const;
  DatasetSpec test(int fold) const;

 private:
  std::uint64_t validation_count(std::uint64_t number) const;
  DatasetSpec part(const char* name, const FoldPart& fold) const;
};

/// Reads `"folds": {"count", "presses", "validation", "rows", "seed"}`; none where there is no such
/// key. The training set must be read already, and be one of measured frames with known places.
/// Throws InputError.
std::optional<Folds> read_folds(JsonObject& root, const Experiment& experiment);

/// For keys of records.
nlohmann::json to_json(const Folds& folds);

}  // namespace ertbench
