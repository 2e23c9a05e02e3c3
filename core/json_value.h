#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

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

}  // namespace ertbench
