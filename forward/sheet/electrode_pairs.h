#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ertbench {

class JsonObject;

/// Two electrodes, 0 ... L-1. As a drive -I goes into `first` and +I into `second`; as a
/// measurement it reads V_first - V_second.
struct ElectrodePair {
  int first;
  int second;
  bool operator==(const ElectrodePair&) const = default;
};

/// The pairs by which a sensor is driven, or measured: every electrode k with k + 1 ("adjacent"),
/// with k + 1 + skip ("skip"), with k + L/2 ("opposite", so that every pair comes both ways round),
/// all mod L, or those listed.
struct PairPattern {
  enum class Kind { adjacent, skip, opposite, listed };

  Kind kind = Kind::adjacent;
  int skip = 0;                       ///< electrodes between the two, of Kind::skip
  std::vector<ElectrodePair> listed;  ///< of Kind::listed

  bool operator==(const PairPattern&) const = default;
  bool is_adjacent() const { return kind == Kind::adjacent; }
};

/// The pairs in their order, for `electrodes` electrodes.
std::vector<ElectrodePair> pairs_of(const PairPattern& pattern, int electrodes);

/// Reads "adjacent", "opposite", {"skip": k} or [[first, second], ...] at `key`; absent, it is
/// `fallback`. Throws InputError where the electrodes are not there, or an odd number of them has
/// no opposites.
PairPattern pair_pattern_from_json(JsonObject& object, const std::string& key,
                                   const PairPattern& fallback, int electrodes);

nlohmann::json to_json(const PairPattern& pattern);

}  // namespace ertbench
