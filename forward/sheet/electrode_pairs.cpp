#include "forward/sheet/electrode_pairs.h"

#include <nlohmann/json.hpp>

#include "core/json_reader.h"
#include "core/json_text.h"

namespace ertbench {
namespace {

constexpr const char* pattern_forms =
    R"(must be "adjacent", "opposite", {"skip": k} or a list of pairs [first, second])";

std::vector<ElectrodePair> listed_pairs(JsonObject& object, const std::string& key,
                                        int electrodes) {
  std::vector<ElectrodePair> pairs;
  for (const nlohmann::json& pair : object.raw(key)) {
    const bool are_two = pair.is_array() && pair.size() == 2 && pair[0].is_number_integer() &&
                         pair[1].is_number_integer();
    if (!are_two) object.fail(key, std::string(pattern_forms) + ", got " + json_shown(pair));
    for (const nlohmann::json& electrode : pair) {
      if (electrode < 0 || electrode >= electrodes) {
        object.fail(key, "names electrodes from 0 to " + std::to_string(electrodes - 1) + ", got " +
                             json_shown(electrode));
      }
    }
    if (pair[0] == pair[1]) {
      object.fail(key, "must name two different electrodes, got " + json_shown(pair));
    }
    pairs.push_back({pair[0].get<int>(), pair[1].get<int>()});
  }
  if (pairs.empty() || pairs.size() > 4096) {
    object.fail(key, "must hold 1 to 4096 pairs, holds " + std::to_string(pairs.size()));
  }
  return pairs;
}

}  // namespace

std::vector<ElectrodePair> pairs_of(const PairPattern& pattern, int electrodes) {
  if (pattern.kind == PairPattern::Kind::listed) return pattern.listed;
  int step = 1;
  if (pattern.kind == PairPattern::Kind::skip) step = 1 + pattern.skip;
  if (pattern.kind == PairPattern::Kind::opposite) step = electrodes / 2;
  std::vector<ElectrodePair> pairs;
  for (int k = 0; k < electrodes; ++k) pairs.push_back({k, (k + step) % electrodes});
  return pairs;
}

PairPattern pair_pattern_from_json(JsonObject& object, const std::string& key,
                                   const PairPattern& fallback, int electrodes) {
  PairPattern pattern = fallback;
  if (object.has(key)) {
    const nlohmann::json& value = object.raw(key);
    pattern = {};
    if (value.is_string()) {
      if (object.choice(key, {"adjacent", "opposite"}) == "opposite") {
        pattern.kind = PairPattern::Kind::opposite;
      }
    } else if (value.is_object()) {
      JsonObject skip = object.object(key);
      pattern.kind = PairPattern::Kind::skip;
      pattern.skip = skip.integer("skip", 0, electrodes - 2);
      skip.finish();
      if (pattern.skip == 0) pattern = {};  // another word for "adjacent"
    } else if (value.is_array()) {
      pattern.kind = PairPattern::Kind::listed;
      pattern.listed = listed_pairs(object, key, electrodes);
    } else {
      object.fail(key, std::string(pattern_forms) + ", got " + json_shown(value));
    }
  }
  if (pattern.kind == PairPattern::Kind::opposite && electrodes % 2 != 0) {
    object.fail(key, "\"opposite\" needs an even number of electrodes, the sensor has " +
                         std::to_string(electrodes) + R"(; use {"skip": k})");
  }
  return pattern;
}

nlohmann::json to_json(const PairPattern& pattern) {
  switch (pattern.kind) {
    case PairPattern::Kind::adjacent:
      return "adjacent";
    case PairPattern::Kind::opposite:
      return "opposite";
    case PairPattern::Kind::skip:
      return {{"skip", pattern.skip}};
    default:
      break;
  }
  nlohmann::json list = nlohmann::json::array();
  for (const ElectrodePair& pair : pattern.listed) list.push_back({pair.first, pair.second});
  return list;
}

}  // namespace ertbench
