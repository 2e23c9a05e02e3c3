#include "core/fields.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace ertbench {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

ordered_json number_schema(const Range& range) {
  ordered_json out = {{"type", "number"}};
  if (std::isfinite(range.low)) out[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (std::isfinite(range.high)) out["maximum"] = range.high;
  return out;
}

ordered_json integer_schema(int low, int high) {
  return {{"type", "integer"}, {"minimum", low}, {"maximum", high}};
}

ordered_json list_schema(const ordered_json& item, std::size_t least, std::size_t most) {
  return {{"type", "array"}, {"items", item}, {"minItems", least}, {"maxItems", most}};
}

ordered_json one_of(const ordered_json& first, const ordered_json& second) {
  return {{"oneOf", {first, second}}};
}

ordered_json interval_schema(const ordered_json& end) {
  return one_of(end, list_schema(end, 2, 2));
}

}  // namespace

void Fields::read(JsonObject object, const Visit& visit) {
  read_some(object, visit);
  object.finish();
}

void Fields::read_some(JsonObject& object, const Visit& visit) {
  Fields fields;
  fields.object_ = &object;
  visit(fields);
}

json Fields::written(const Visit& visit) {
  json out = json::object();
  Fields fields;
  fields.out_ = &out;
  visit(fields);
  return out;
}

ordered_json Fields::schema(const Visit& visit) {
  ordered_json out = ordered_json::object();
  out["type"] = "object";
  out["required"] = ordered_json::array();
  out["additionalProperties"] = false;
  out["properties"] = ordered_json::object();
  Fields fields;
  fields.schema_ = &out;
  visit(fields);
  if (out["required"].empty()) out.erase("required");
  return out;
}

void Fields::fail(const char* key, const std::string& message) const {
  object_->fail(key, message);
}

std::string Fields::place(const char* key) const {
  return (object_->source().empty() ? "" : object_->source() + ": ") + object_->path_of(key);
}

Fields& Fields::required() {
  required_ = true;
  return *this;
}

Fields& Fields::derived() {
  derived_ = true;
  return *this;
}

Fields& Fields::nullable() {
  nullable_ = true;
  return *this;
}

bool Fields::is_given(const char* key) {
  const bool required = std::exchange(required_, false);
  const bool nullable = std::exchange(nullable_, false);
  if (!required && !object_->has(key)) return false;
  return !nullable || !object_->raw(key).is_null();
}

void Fields::leave_out(const char* key) {
  required_ = false;
  if (std::exchange(nullable_, false)) (*out_)[key] = nullptr;
}

void Fields::field(const char* key, const std::function<void()>& read, const json& value,
                   const ordered_json& schema) {
  const bool required = required_;
  const bool derived = std::exchange(derived_, false);
  if (reading()) {
    if (is_given(key)) read();
    return;
  }
  if (writing() && value.is_null()) return leave_out(key);
  required_ = nullable_ = false;
  if (writing()) {
    (*out_)[key] = value;
    return;
  }
  ordered_json property = schema;
  if (required) {
    (*schema_)["required"].push_back(key);
  } else if (!derived && !value.is_null()) {
    property["default"] = ordered_json(value);
  }
  (*schema_)["properties"][key] = std::move(property);
}

void Fields::number(const char* key, double& value, Range range) {
  field(
      key, [&] { value = object_->number(key, range); }, value, number_schema(range));
}

void Fields::number(const char* key, std::optional<double>& value, Range range) {
  field(
      key, [&] { value = object_->number(key, range); },
      value && std::isfinite(*value) ? json(*value) : json(), number_schema(range));
}

void Fields::number_or_auto(const char* key, std::optional<double>& value, Range range) {
  const auto read = [&] {
    const json& given = object_->raw(key);
    const bool usable = given.is_number() && range.contains(given.get<double>());
    if (!usable && given != "auto") {
      fail(key, range.text() + " or \"auto\", got " + json_shown(given));
    }
    value = usable ? std::optional(given.get<double>()) : std::nullopt;
  };
  field(key, read, value ? json(*value) : json("auto"),
        one_of({{"enum", {"auto"}}}, number_schema(range)));
}

void Fields::integer(const char* key, int& value, int low, int high) {
  field(
      key, [&] { value = object_->integer(key, low, high); }, value, integer_schema(low, high));
}

void Fields::integer(const char* key, std::uint64_t& value, int low, int high) {
  field(
      key, [&] { value = static_cast<std::uint64_t>(object_->integer(key, low, high)); }, value,
      integer_schema(low, high));
}

void Fields::boolean(const char* key, bool& value) {
  field(key, [&] { value = object_->boolean_or(key, value); }, value, {{"type", "boolean"}});
}

void Fields::text(const char* key, std::string& value) {
  field(key, [&] { value = object_->text(key); }, value.empty() ? json() : json(value),
        {{"type", "string"}, {"minLength", 1}});
}

void Fields::words(const char* key, std::string& value) {
  const auto read = [&] {
    const json& given = object_->raw(key);
    if (!given.is_string()) fail(key, "must be a string");
    value = given.get<std::string>();
  };
  field(key, read, value, {{"type", "string"}});
}

void Fields::any(const char* key, JsonValue& value) {
  field(
      key, [&] { value = object_->raw(key); }, *value, ordered_json::object());
}

void Fields::interval(const char* key, std::pair<double, double>& value, Range range) {
  field(
      key, [&] { value = object_->interval(key, range); }, value,
      interval_schema(number_schema(range)));
}

void Fields::interval(const char* key, std::optional<std::pair<double, double>>& value,
                      Range range) {
  field(
      key, [&] { value = object_->interval(key, range); }, or_null(value),
      interval_schema(number_schema(range)));
}

void Fields::interval(const char* key, std::pair<int, int>& value, int low, int high) {
  field(
      key, [&] { value = object_->integer_interval(key, low, high); }, value,
      interval_schema(integer_schema(low, high)));
}

void Fields::numbers(const char* key, std::span<double> values, Range range) {
  const auto read = [&] {
    const std::vector<double> given = object_->numbers(key, values.size(), range);
    std::copy(given.begin(), given.end(), values.begin());
  };
  field(key, read, std::vector<double>(values.begin(), values.end()),
        list_schema(number_schema(range), values.size(), values.size()));
}

void Fields::rows(const char* key, std::uint64_t& first, std::uint64_t& last, std::uint64_t most) {
  const auto read = [&] {
    if (object_->raw(key).is_null()) return;
    const std::vector<double> ends = object_->numbers(key, 2, {0, static_cast<double>(most)});
    first = static_cast<std::uint64_t>(ends[0]);
    last = static_cast<std::uint64_t>(ends[1]);
    if (ends[0] != std::floor(ends[0]) || ends[1] != std::floor(ends[1]) || first >= last) {
      fail(key, "must be [first, last), whole numbers with first < last");
    }
  };
  field(key, read, {first, last}, {{"$ref", "#/definitions/rows"}});
}

void Fields::list(const char* key, std::vector<double>& values, Range range) {
  const auto read = [&] {
    const json& given = object_->raw(key);
    if (!given.is_array() || given.empty()) {
      fail(key, "must be a list of numbers, got " + json_shown(given));
    }
    values = object_->numbers(key, given.size(), range);
  };
  field(key, read, values, {{"type", "array"}, {"minItems", 1}, {"items", number_schema(range)}});
}

void Fields::integers(const char* key, std::vector<int>& values, std::size_t least,
                      std::size_t most, std::pair<int, int> range) {
  field(
      key, [&] { values = object_->integers(key, least, most, range); }, values,
      list_schema(integer_schema(range.first, range.second), least, most));
}

void Fields::name(const char* key, std::string& value, const std::vector<std::string>& names) {
  field(
      key, [&] { value = object_->choice(key, names); }, value.empty() ? json() : json(value),
      names.empty() ? ordered_json{{"type", "string"}} : ordered_json{{"enum", names}});
}

void Fields::object(const char* key, const Visit& visit) {
  field(
      key, [&] { read(object_->object(key), visit); }, writing() ? written(visit) : json(),
      describing() ? schema(visit) : ordered_json());
}

}  // namespace ertbench
