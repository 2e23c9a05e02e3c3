#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/random.h"
#include "forward/touch/indenter.h"

namespace ertbench {

class JsonObject;
struct Sensor;

/// Places at equal distances in columns and rows around the sheet's centre, those of the first row
/// (least y) first.
struct PlaceGrid {
  int columns = 1;
  int rows = 1;
  Eigen::Vector2d spacing_mm = {1, 1};
  Eigen::Vector2d shift_mm = {0, 0};  ///< of all places

  int count() const { return columns * rows; }
  Eigen::Vector2d place_mm(int index) const;

  bool operator==(const PlaceGrid&) const = default;
};

/// Touches at rest on a skin, drawn at random. Every quantity is uniform in its interval.
struct TouchDistribution {
  std::pair<int, int> touches = {1, 1};            ///< in a scene
  std::vector<Indenter> indenters = {Indenter{}};  ///< each touch has one of them
  std::pair<double, double> size = {1, 1};         ///< factor of its lengths
  std::pair<double, double> force_N = {1, 10};
  double margin_mm = 10;  ///< centres are at least so far from the border
  /// Between the circles around a touch and around the nearest of those before it; random, and at
  /// places that have it.
  std::optional<std::pair<double, double>> gap_mm;
  /// Of scenes with one touch: scene i is at place i modulo their count.
  std::optional<PlaceGrid> places;
  int draws = 1;              ///< frames of a scene, each with noise and faults of its own
  double blank_fraction = 0;  ///< share of scenes without a touch

  /// The touches of frame `index`. `random` is keyed by scene_of(index).
  std::vector<Touch> draw(std::uint64_t index, RandomStream& random, const Sensor& sensor) const;
  std::uint64_t scene_of(std::uint64_t index) const {
    return index / static_cast<std::uint64_t>(draws);
  }
};

/// Reads `{"touches", "indenters", "size", "force_N", "margin_mm", "gap_mm", "places": {"grid":
/// [columns, rows], "spacing_mm", "shift_mm"}, "draws", "blank_fraction"}`; an interval is [low,
/// high] or one number. The sensor must have a skin.
TouchDistribution touch_distribution_from_json(JsonObject object, const Sensor& sensor);
nlohmann::json to_json(const TouchDistribution& distribution);
nlohmann::ordered_json touches_schema();

}  // namespace ertbench
