#include "bench/analysis/training_curves.h"

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  if (line.ends_with(',')) fields.emplace_back();
  return fields;
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be opened");
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    if (in.eof()) break;  // no line end: still being written, or cut off
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty()) lines.push_back(line);
  }
  return lines;
}

}  // namespace

TrainingCurves read_training_curves(const std::filesystem::path& file) {
  const std::vector<std::string> lines = lines_of(file);
  TrainingCurves curves;
  if (!lines.empty()) curves.columns = fields_of(lines.front());
  if (curves.columns.empty() || curves.columns.front() != "epoch") {
    throw InputError(file.string() + ": line 1: must name the columns, \"epoch\" first");
  }
  curves.values.resize(curves.columns.size());
  for (std::size_t l = 1; l < lines.size(); ++l) {
    const auto fail = [&](const std::string& what) {
      throw InputError(file.string() + ": line " + std::to_string(l + 1) + ": " + what);
    };
    const std::vector<std::string> fields = fields_of(lines[l]);
    if (fields.size() != curves.columns.size()) {
      fail("must hold " + std::to_string(curves.columns.size()) + " numbers, holds " +
           std::to_string(fields.size()));
    }
    for (std::size_t c = 0; c < fields.size(); ++c) {
      char* end = nullptr;
      const double value = std::strtod(fields[c].c_str(), &end);
      if (fields[c].empty() || *end != '\0')
        fail("\"" + printable(fields[c]) + "\" is not a number");
      curves.values[c].push_back(value);
    }
  }
  return curves;
}

}  // namespace ertbench
