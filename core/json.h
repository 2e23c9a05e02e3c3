#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/errors.h"

namespace ertbench {

/// An immutable JSON value, for structs whose headers need not include the library. Copies share
/// the value and are cheap.
///
///   struct Row { JsonValue parameters; };
///   row.parameters = nlohmann::json{{"lambda", 0.1}};
///   const double lambda = row.parameters->at("lambda");
class JsonValue {
 public:
  JsonValue() = default;            ///< null
  JsonValue(nlohmann::json value);  // implicit
  static JsonValue object();        ///< {}
  static JsonValue array();         ///< []

  const nlohmann::json& operator*() const;
  const nlohmann::json* operator->() const { return &**this; }
  /// False for null.
  explicit operator bool() const;
  /// Compact JSON text; empty for null.
  std::string text() const;

  friend bool operator==(const JsonValue& a, const JsonValue& b);

 private:
  std::shared_ptr<const nlohmann::json> value_;
};

/// Largest JSON text that is read. The library needs up to 16 times as much memory.
inline constexpr std::uint64_t most_json_bytes = std::uint64_t{64} << 20U;
/// Largest record of the program itself, which has a kilobyte per frame.
inline constexpr std::uint64_t most_record_bytes = std::uint64_t{1} << 30U;
/// Deepest nesting of arrays and objects; the library parses them recursively.
inline constexpr int most_json_levels = 64;

/// Parses JSON text; no other function does. `source` names the text in messages: a file, or an
/// attribute of one. Throws InputError if the text is too long or nested too deeply, which is found
/// before it is parsed, if it is not JSON (with line and column), and if an object has a key twice.
nlohmann::json parse_json(std::string_view text, const std::string& source,
                          std::uint64_t most_bytes = most_json_bytes);

/// Throws the InputError of parse_json if `bytes` exceeds `most_bytes`.
void require_json_size(std::uint64_t bytes, const std::string& source, std::uint64_t most_bytes);

/// The text of a value, compact or indented by `indent` spaces per level. Never throws: bytes that
/// are not UTF-8, which a plugin may have put into a string, become U+FFFD.
std::string json_text(const nlohmann::json& value, int indent = -1);

/// The first 60 characters of a value, printable, for messages.
std::string json_shown(const nlohmann::json& value);

/// The value, or null.
template <typename Value, typename Json = nlohmann::json>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

/// A copy whose strings and keys are printable and at most `most` characters long.
nlohmann::json printable_json(const nlohmann::json& value, std::size_t most = 200);

/// Reads and parses a JSON file. Throws InputError if it is no regular file or too large, and for
/// what parse_json refuses.
nlohmann::json read_json_file(const std::filesystem::path& file,
                              std::uint64_t most_bytes = most_json_bytes);

/// Separates, in the name of a source, a file from those that it extends: "noisy.json (extends
/// quick.json)".
inline constexpr const char* extends_mark = " (extends ";

/// The absolute folder of the first file in the name of a source.
std::filesystem::path folder_of_source(const std::string& source);

/// A closed or half-open interval that a number must lie in.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  ///< low itself is excluded
  const char* unit = "";  ///< for messages: "A"

  static Range positive() { return {0, std::numeric_limits<double>::infinity(), true}; }
  static Range at_least(double low) { return {low}; }
  bool contains(double x) const { return low_open ? x > low && x <= high : x >= low && x <= high; }
  std::string text() const;  ///< "must be > 0", "must be from 1e-09 to 100 A"
};

/// The InputError of a JSON value: "SOURCE: PATH: MESSAGE".
class JsonError : public InputError {
 public:
  JsonError(const std::string& source, std::string path, std::string message);
  const std::string& path() const { return path_; }
  const std::string& message() const { return message_; }

 private:
  std::string path_;
  std::string message_;
};

/// A strict view of one JSON object: every key is read with its type and range, and `finish`
/// refuses keys that were not read. All errors are JsonErrors with the source (a file name) and the
/// path.
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
  /// One of the strings in `choices`.
  std::string choice(std::string_view key, const std::vector<std::string>& choices);
  std::string choice_or(std::string_view key, std::string_view fallback,
                        const std::vector<std::string>& choices);
  /// [low, high], or one number for both.
  std::pair<double, double> interval(std::string_view key, Range range);
  std::pair<int, int> integer_interval(std::string_view key, int low, int high);
  /// A list of strings, each one of `choices`; not empty.
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
  /// The value, marked as read.
  const nlohmann::json& raw(std::string_view key);
  /// All keys in order, for objects whose keys are names that the user chose.
  std::vector<std::string> keys() const;

  const nlohmann::json& value() const { return *value_; }
  const std::string& source() const { return source_; }
  /// The folder that relative paths in it start from (folder_of_source).
  std::filesystem::path folder() const;
  std::string path_of(std::string_view key) const;

  /// Throws the JsonError at `key` of this object, or at the object itself for "".
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;

  /// Throws if there is a key that was never read, and suggests the nearest one that was.
  void finish() const;

 private:
  void note(std::string_view key) const { known_.emplace(key); }

  const nlohmann::json* value_;
  std::string source_;
  std::string path_;
  mutable std::set<std::string, std::less<>> known_;
};

}  // namespace ertbench
