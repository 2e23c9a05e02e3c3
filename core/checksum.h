#pragma once

#include <memory>
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

}  // namespace ertbench
