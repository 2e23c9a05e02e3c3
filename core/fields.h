#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/json.h"

namespace ertbench {

/// Visits the fields of a struct in order to read them from JSON, to write them to JSON, or to
/// describe them in a JSON schema. A struct lists its fields once, in a function, and gets all
/// three:
///
///   void visit(Fields& fields, Foam& foam) {
///     fields.number("thickness_mm", foam.thickness_mm, {0.01, 1000, false, "mm"});
///     fields.number("prompt_share", foam.prompt_share, {0, 1});
///   }
///   Fields::read(object, [&](Fields& fields) { visit(fields, foam); });
///   json = Fields::written([&](Fields& fields) { visit(fields, foam); });
///   schema = Fields::schema([&](Fields& fields) { visit(fields, foam); });
///
/// A field is optional unless `required()` precedes it; the value that the member has before it is
/// read is its default. Reading throws the InputErrors of JsonObject. The schema has types, ranges
/// and defaults; the sentences that describe a field stand in the schema's file (update_schema).
class Fields {
 public:
  using Visit = std::function<void(Fields&)>;

  /// Reads all keys of `object`, and refuses those that no field has.
  static void read(JsonObject object, const Visit& visit);
  /// Reads some keys of `object`, of which the caller reads others and calls `finish`.
  static void read_some(JsonObject& object, const Visit& visit);
  /// An object with a key for each field.
  static nlohmann::json written(const Visit& visit);
  /// `{"type": "object", "required", "additionalProperties": false, "properties"}`.
  static nlohmann::ordered_json schema(const Visit& visit);

  bool reading() const { return object_ != nullptr; }
  bool writing() const { return out_ != nullptr; }
  bool describing() const { return schema_ != nullptr; }
  /// Whether the object that is read has the key.
  bool has(const char* key) const { return reading() && object_->has(key); }
  /// Where a field stands that is read, for messages: "a.json: /solvers/2/lambda".
  std::string place(const char* key) const;
  /// Refuses the value just read at `key`. Only while reading.
  [[noreturn]] void fail(const char* key, const std::string& message) const;

  /// The next field must stand in the JSON.
  Fields& required();
  /// The default of the next field depends on other fields; the schema leaves it out.
  Fields& derived();
  /// Where the next field has no value, null is written, and null is read as none.
  Fields& nullable();

  void number(const char* key, double& value, Range range);
  /// Left out where it has no value, or none that is finite.
  void number(const char* key, std::optional<double>& value, Range range);
  /// "auto" stands for no value.
  void number_or_auto(const char* key, std::optional<double>& value, Range range);
  void integer(const char* key, int& value, int low, int high);
  void integer(const char* key, std::uint64_t& value, int low, int high);
  void boolean(const char* key, bool& value);
  void text(const char* key, std::string& value);
  /// A text that may be empty.
  void words(const char* key, std::string& value);
  /// Any JSON, left out where it is null.
  void any(const char* key, JsonValue& value);
  /// [low, high], or one number for both.
  void interval(const char* key, std::pair<double, double>& value, Range range);
  void interval(const char* key, std::optional<std::pair<double, double>>& value, Range range);
  void interval(const char* key, std::pair<int, int>& value, int low, int high);
  /// As many numbers as `values` has.
  void numbers(const char* key, std::span<double> values, Range range);
  /// [first, last), first < last <= most.
  void rows(const char* key, std::uint64_t& first, std::uint64_t& last, std::uint64_t most);
  /// A list of one number or more.
  void list(const char* key, std::vector<double>& values, Range range);
  /// `least` to `most` whole numbers.
  void integers(const char* key, std::vector<int>& values, std::size_t least, std::size_t most,
                std::pair<int, int> range);
  template <std::size_t Size>
  void integers(const char* key, std::array<int, Size>& values, std::pair<int, int> range) {
    std::vector<int> list(values.begin(), values.end());
    integers(key, list, Size, Size, range);
    std::copy(list.begin(), list.end(), values.begin());
  }
  /// One of the named values.
  template <typename Value>
  void choice(const char* key, Value& value,
              std::initializer_list<std::pair<const char*, Value>> of) {
    std::vector<std::string> names;
    std::string name;
    for (const auto& [one, meaning] : of) {
      names.emplace_back(one);
      if (meaning == value) name = one;
    }
    this->name(key, name, names);
    for (const auto& [one, meaning] : of) {
      if (name == one) value = meaning;
    }
  }
  /// One of `names`; any where there are none.
  void name(const char* key, std::string& value, const std::vector<std::string>& names);
  /// An object with fields of its own, whose defaults stand where it is left out.
  void object(const char* key, const Visit& visit);
  /// As above for an optional struct.
  template <typename Struct, typename VisitStruct>
  void object(const char* key, std::optional<Struct>& value, const VisitStruct& visit) {
    if (reading() && !is_given(key)) return;
    if (writing() && !value) return leave_out(key);
    Struct present = value.value_or(Struct{});
    object(key, [&](Fields& fields) { visit(fields, present); });
    if (reading()) value = std::move(present);
  }

 private:
  Fields() = default;
  /// Whether the field is to be read: it stands in the object, or must, and has a value.
  bool is_given(const char* key);
  /// Writes nothing of a field without a value, or null.
  void leave_out(const char* key);
  /// Reads, writes or describes a field. `value`: null for a field that is not written and has no
  /// default.
  void field(const char* key, const std::function<void()>& read, const nlohmann::json& value,
             const nlohmann::ordered_json& schema);

  JsonObject* object_ = nullptr;
  nlohmann::json* out_ = nullptr;
  nlohmann::ordered_json* schema_ = nullptr;
  bool required_ = false;
  bool derived_ = false;
  bool nullable_ = false;
};

}  // namespace ertbench
