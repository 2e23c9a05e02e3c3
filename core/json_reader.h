#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/json_text.h"

namespace ertbench {

/// Reads and parses a JSON file. Throws InputError naming the file where it is no regular file, or
/// too large, and for what parse_json refuses.
nlohmann::json read_json_file(const std::filesystem::path& file,
                              std::uint64_t most_bytes = most_json_bytes);

/// Stands in the name of a source between a file and those that it extends: "noisy.json (extends
/// quick.json)".
inline constexpr const char* extends_mark = " (extends ";

/// The absolute folder of the file that a source begins with.
std::filesystem::path folder_of_source(const std::string& source);

/// A closed or half-open interval that a number must lie in.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< low itself is excluded
  const char* unit = "";  ///< of both, for messages: "A"

  static Range positive() { return {0, std::numeric_limits<double>::infinity(), true}; }
  static Range at_least(double low) { return {low}; }
  bool contains(double x) const { return low_open ? x > low && x <= high : x >= low && x <= high; }
  std::string text() const;  ///< "must be > 0", "must be from 1e-09 to 100 A"
};

/// A strict view of one JSON object: every key is read by its type and range, and `finish` refuses
/// whatever was not read. All errors are InputErrors that begin with the place: the source (a file
/// name) and the JSON path.
class JsonObject {
 public:
  /// `source` names the file (may be empty), `path` the JSON path of `value` ("" for the root).
  JsonObject(const nlohmann::json& value, std::string source, std::string path);

  bool has(std::string_view key) const;

  double number(std::string_view key, Range range = {});
  double number_or(std::string_view key, double fallback, Range range = {});
  int integer(std::string_view key, int low, int high);
  int integer_or(std::string_view key, int fallback, int low, int high);
  bool boolean_or(std::string_view key, bool fallback);
  std::string text(std::string_view key);
  std::string text_or(std::string_view key, std::string_view fallback);
  /// A string out of a list.
  std::string choice(std::string_view key, const std::vector<std::string>& choices);
  std::string choice_or(std::string_view key, std::string_view fallback,
                        const std::vector<std::string>& choices);
  /// [low, high], or one number for both.
  std::pair<double, double> interval(std::string_view key, Range range);
  std::pair<int, int> integer_interval(std::string_view key, int low, int high);
  /// A list of strings out of a list, not empty.
  std::vector<std::string> choices(std::string_view key, const std::vector<std::string>& choices);
  /// A list of [x, y].
  std::vector<std::array<double, 2>> points(std::string_view key, std::size_t least,
                                            std::size_t most, Range range);
  /// An array of `size` numbers.
  std::vector<double> numbers(std::string_view key, std::size_t size, Range range = {});

  /// An array of `least` to `most` whole numbers, each in `range`.
  std::vector<int> integers(std::string_view key, std::size_t least, std::size_t most,
                            std::pair<int, int> range);

  JsonObject object(std::string_view key);
  std::vector<JsonObject> objects(std::string_view key);  ///< an array of objects
  /// The value itself, marked as read.
  const nlohmann::json& raw(std::string_view key);
  /// All keys in order; used where the keys are names of the user's.
  std::vector<std::string> keys() const;

  const nlohmann::json& value() const { return *value_; }
  const std::string& source() const { return source_; }
  /// What relative paths in it count from, see folder_of_source.
  std::filesystem::path folder() const;
  std::string path_of(std::string_view key) const;

  /// Throws InputError at `key` of this object ("" for the object itself).
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;

  /// Refuses keys that were never asked for, suggesting the nearest one that was.
  void finish() const;

 private:
  const nlohmann::json& at(std::string_view key);
  void note(std::string_view key) const { known_.emplace(key); }

  const nlohmann::json* value_;
  std::string source_;
  std::string path_;
  mutable std::set<std::string, std::less<>> known_;
};

}  // namespace ertbench
