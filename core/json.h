#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ertbench {

/// A JSON value as a member of a struct whose header need not include the library. It never changes
/// once it is there, so that copies are cheap: they share it.
///
///   struct Row { JsonValue parameters; };
///   row.parameters = nlohmann::json{{"lambda", 0.1}};
///   const double lambda = row.parameters->at("lambda");
class JsonValue {
 public:
  JsonValue() = default;            ///< null
  JsonValue(nlohmann::json value);  // implicit: it is the same value
  static JsonValue object();        ///< {}
  static JsonValue array();         ///< []

  const nlohmann::json& operator*() const;
  const nlohmann::json* operator->() const { return &**this; }
  /// Whether there is a value, that is another than null.
  explicit operator bool() const;
  /// Compact JSON text; empty for null.
  std::string text() const;

  friend bool operator==(const JsonValue& a, const JsonValue& b);

 private:
  std::shared_ptr<const nlohmann::json> value_;
};

/// Bytes of JSON that are read: the library takes up to 16 times as many of memory.
inline constexpr std::uint64_t most_json_bytes = std::uint64_t{64} << 20U;
/// Of a record of ours, which has a kilobyte for each frame.
inline constexpr std::uint64_t most_record_bytes = std::uint64_t{1} << 30U;
/// Arrays and objects within each other: the library walks through them by calling itself.
inline constexpr int most_json_levels = 64;

/// The only way from bytes to JSON. `source` names them in messages: a file, an attribute of one.
/// Throws InputError where they are too many or nested too deeply (found before anything is made of
/// them), where they are not JSON, with line and column, and where a key stands twice in an object.
nlohmann::json parse_json(std::string_view text, const std::string& source,
                          std::uint64_t most_bytes = most_json_bytes);

/// Throws the InputError of parse_json for too many bytes.
void require_json_size(std::uint64_t bytes, const std::string& source, std::uint64_t most_bytes);

/// The text of a value, compact or with so many spaces for each level. Never throws: bytes in
/// strings that are not UTF-8, as a plugin may have put there, become U+FFFD.
std::string json_text(const nlohmann::json& value, int indent = -1);

/// A value of the user's as a message shows it: its first 60 characters, printable.
std::string json_shown(const nlohmann::json& value);

/// The value with its strings and keys printable, of at most `most` characters each.
nlohmann::json printable_json(const nlohmann::json& value, std::size_t most = 200);

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
