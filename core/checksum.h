#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

struct XXH3_state_s;  // of xxhash.h

namespace ertbench {

/// A hash (XXH3, 128 bits) of bytes that come piece by piece: it tells accidental changes, not
/// forgeries.
class Checksum {
 public:
  Checksum();

  void add(std::string_view bytes);
  /// 32 hexadecimal digits.
  std::string text() const;

 private:
  std::unique_ptr<XXH3_state_s, void (*)(XXH3_state_s*)> state_;
};

/// Adds "checksum", the hash of all else in the object.
void add_checksum(nlohmann::json& object);

/// Takes the checksum out again. Why the object is not what was written: "it has no checksum", "it
/// has been changed since it was written"; empty where it is.
std::string take_checksum(nlohmann::json& object);

}  // namespace ertbench
