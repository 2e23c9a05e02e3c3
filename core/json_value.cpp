#include "core/json_value.h"

#include <nlohmann/json.hpp>

#include "core/json_text.h"

namespace ertbench {

using nlohmann::json;

JsonValue::JsonValue(json value) : value_(std::make_shared<const json>(std::move(value))) {}

JsonValue JsonValue::object() { return json::object(); }

JsonValue JsonValue::array() { return json::array(); }

const json& JsonValue::operator*() const {
  static const json null;
  return value_ ? *value_ : null;
}

JsonValue::operator bool() const { return !(*this)->is_null(); }

std::string JsonValue::text() const { return *this ? json_text(**this) : ""; }

bool operator==(const JsonValue& a, const JsonValue& b) { return *a == *b; }

}  // namespace ertbench
