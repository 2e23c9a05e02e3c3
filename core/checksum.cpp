#include "core/checksum.h"

#include <xxhash.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/build_stamp.h"
#include "core/json.h"

namespace ertbench {

Checksum::Checksum()
    : state_(XXH3_createState(), [](XXH3_state_s* state) { XXH3_freeState(state); }) {
  XXH3_128bits_reset(state_.get());
}

void Checksum::add(std::string_view bytes) {
  XXH3_128bits_update(state_.get(), bytes.data(), bytes.size());
}

std::string Checksum::text() const {
  const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
  char digits[33];
  std::snprintf(digits, sizeof digits, "%016llx%016llx",
                static_cast<unsigned long long>(hash.high64),
                static_cast<unsigned long long>(hash.low64));
  return digits;
}

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
