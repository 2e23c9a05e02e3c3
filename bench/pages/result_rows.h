#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/json.h"

namespace ertbench {

/// The rows of result files below one folder, read once each.
class ResultRows {
 public:
  explicit ResultRows(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Those of `file` that `selection` names, in the file's order. `file`: a CSV or JSON file, or
  /// the folder of a result, whose summary.json is meant; of JSON the list "rows". `selection`: a
  /// label, where `*` stands for any text, or several with `|` between them; or conditions on
  /// columns, `axis=snr,solver=tsvd|pdipm,share>0.05`, all of which must hold.
  ///
  /// Whatever is named must be there, each of several too, and where `column` is given must have a
  /// value in it: a sentence about a row that was renamed or never filled would else pass in
  /// silence. What `*`, `<`, `>` and `!=` leave may be nothing.
  ///
  /// Throws InputError where there is no such file, row or value, or where the file cannot be used.
  std::vector<const nlohmann::json*> select(const std::string& file, const std::string& selection,
                                            const std::string& column = "");

 private:
  const nlohmann::json& rows(const std::string& file);

  std::filesystem::path folder_;
  std::map<std::string, JsonValue> files_;
};

/// The value in a row at `column`: a key, or keys and indices with dots between them,
/// `latency_us.p50`. A metric's name alone is its mean, `RIE.ci95.0` the lower end of its interval.
/// Null where there is none.
const nlohmann::json& value_in(const nlohmann::json& row, const std::string& column);

/// The row's name: its label, or its first column of CSV.
std::string label_of(const nlohmann::json& row);

}  // namespace ertbench
