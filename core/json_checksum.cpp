#include "core/json_checksum.h"

#include <nlohmann/json.hpp>

#include "core/build_stamp.h"
#include "core/json_text.h"

namespace ertbench {

void add_checksum(nlohmann::json& object) {
  object.erase("checksum");
  object["checksum"] = hash_of(json_text(object));
}

std::string take_checksum(nlohmann::json& object) {
  if (!object.is_object() || !object.contains("checksum")) return "it has no checksum";
  const nlohmann::json checksum = object.at("checksum");
  object.erase("checksum");
  return checksum == hash_of(json_text(object)) ? "" : "it has been changed since it was written";
}

}  // namespace ertbench
