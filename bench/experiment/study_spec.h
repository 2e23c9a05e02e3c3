#pragma once

#include <map>
#include <string>
#include <vector>

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

}  // namespace ertbench
