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

/// Positions at equal distances in columns and rows around the sheet's centre, row by row from the
/// least y on.
struct PlaceGrid {
  int columns = 1;
  int rows = 1;
  Eigen::Vector2d spacing_mm = {1, 1};
  Eigen::Vector2d shift_mm = {0, 0};  ///< of all positions

  int count() const { return columns * rows; }
  Eigen::Vector2d place_mm(int index) const;

  bool operator==(const PlaceGrid&) const = default;
};

/// Touches at rest on a skin, drawn at random. Every quantity is uniform in its interval.
struct TouchDistribution {
  std::pair<int, int> touches = {1, 1};            ///< in a scene
  std::vector<Indenter> indenters = {Indenter{}};  ///< each touch has one of them, at random
  std::pair<double, double> size = {1, 1};         ///< factor of the indenter's lengths
  std::pair<double, double> force_N = {1, 10};
  double margin_mm = 10;  ///< least distance of centres from the border
  /// Gap between the circles around a touch and around the nearest of the earlier ones.
  std::optional<std::pair<double, double>> gap_mm;
  /// Positions of scenes with one touch: scene i is at position i modulo their count.
  std::optional<PlaceGrid> places;
  int draws = 1;              ///< frames per scene, each with its own noise and faults
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
