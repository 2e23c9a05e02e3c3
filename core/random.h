#pragma once

#include <Random123/philox.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string_view>

namespace ertbench {

/// Purpose of a stream; a part of its key, so that a new purpose changes no existing stream.
enum class Purpose : std::uint64_t {
  scene = 1,
  noise = 2,
  training = 3,
  fault = 4,         // of the electronics
  displacement = 5,  // of electrodes
  gradient = 6,      // of the background
  battery = 7,
};

/// FNV-1a hash of a name, for use in a key.
constexpr std::uint64_t key_of(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

/// A stream of random numbers that depends on its key only (Philox 4x64, Salmon et al. 2011). A
/// scene draws the same numbers in any order, on any thread and on any platform.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t dataset, std::uint64_t scene, Purpose purpose)
      : key_{{seed, dataset}}, counter_{{0, scene, static_cast<std::uint64_t>(purpose), 0}} {}

  std::uint64_t bits() {
    if (next_ == 4) {
      block_ = r123::Philox4x64()(counter_, key_);
      ++counter_[0];
      next_ = 0;
    }
    return block_[next_++];
  }

  /// Uniform in [0, 1), 53 bits.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform over low ... high, both included.
  int integer(int low, int high) {
    return low + static_cast<int>(uniform() * (static_cast<double>(high) - low + 1));
  }

  /// Standard normal (Box-Muller).
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    const double angle = 2 * std::numbers::pi * uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

 private:
  r123::Philox4x64::key_type key_;
  r123::Philox4x64::ctr_type counter_;
  r123::Philox4x64::ctr_type block_{};
  std::size_t next_ = 4;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace ertbench
