#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"

namespace ertbench {
namespace {

using nlohmann::ordered_json;

/// Puts types, ranges and defaults of a struct into its place in a schema. Descriptions stay, and
/// so do properties that are not fields of the struct.
void update(ordered_json& place, const ordered_json& current) {
  if (current.contains("required")) place["required"] = current.at("required");
  for (const auto& [name, field] : current.at("properties").items()) {
    ordered_json& property = place["properties"][name];
    if (field.contains("properties") && property.contains("properties")) {
      update(property, field);
      continue;
    }
    ordered_json updated = ordered_json::object();
    if (property.contains("description")) updated["description"] = property["description"];
    updated.update(field);
    property = std::move(updated);
  }
}

/// Whether a value is written over several lines: it has properties.
bool is_long(const ordered_json& value) {
  if (!value.is_structured()) return false;
  if (value.contains("properties")) return true;
  for (const auto& [key, one] : value.items()) {
    if (key != "if" && is_long(one)) return true;
  }
  return false;
}

void write(std::string& out, const ordered_json& value, const std::string& indent, bool broken) {
  if (!value.is_structured()) {
    out += value.dump();
    return;
  }
  const bool object = value.is_object();
  const std::string inner = indent + "  ";
  out += object ? '{' : '[';
  bool first = true;
  for (const auto& [key, one] : value.items()) {
    out += first ? "" : broken ? "," : ", ";
    if (broken) out += "\n" + inner;
    if (object) out += ordered_json(key).dump() + ": ";
    write(out, one, inner, broken && key != "if" && (key == "properties" || is_long(one)));
    first = false;
  }
  if (broken) out += "\n" + indent;
  out += object ? '}' : ']';
}

}  // namespace

std::string updated_schema(const std::filesystem::path& file) {
  read_json_file(file);  // refuses what is no JSON
  std::ifstream in(file);
  ordered_json schema = ordered_json::parse(in);
  const std::pair<const char*, ordered_json> parts[] = {
      {"/else", experiment_settings_schema()},
      {"/definitions/ladders", ladder_settings_schema()},
      {"/definitions/faults", faults_schema()},
      {"/definitions/skin", skin_schema()},
      {"/definitions/touches", touches_schema()},
      {"/definitions/sequences", sequence_schema()},
      {"/definitions/measured", measured_schema()}};
  for (const auto& [path, part] : parts) {
    const ordered_json::json_pointer place(path);
    if (schema.contains(place)) update(schema[place], part);
  }
  std::string out;
  write(out, schema, "", true);
  return out + "\n";
}

}  // namespace ertbench
