#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace ertbench {

/// A hash (XXH3, 128 bits) of bytes that come piece by piece: it tells accidental changes, not
/// forgeries.
class Checksum {
 public:
  Checksum();
  Checksum(const Checksum&) = delete;
  Checksum& operator=(const Checksum&) = delete;
  ~Checksum();

  void add(std::string_view bytes);
  /// 32 hexadecimal digits.
  std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Adds "checksum", the hash of all else in the object.
void add_checksum(nlohmann::json& object);

/// Takes the checksum out again. Why the object is not what was written: "it has no checksum", "it
/// has been changed since it was written"; empty where it is.
std::string take_checksum(nlohmann::json& object);

}  // namespace ertbench
