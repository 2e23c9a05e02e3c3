#pragma once

#include <nlohmann/json_fwd.hpp>
#include <utility>
#include <vector>

#include "forward/random.h"
#include "forward/scene.h"

namespace ertbench {

class JsonObject;

/// Random scenes. Every quantity is drawn uniformly and independently from its interval.
struct SceneDistribution {
  std::pair<int, int> contacts = {1, 3};  ///< contacts in a scene
  std::vector<Shape> shapes = {Shape::disc, Shape::ellipse, Shape::rectangle, Shape::polygon};
  std::pair<double, double> radius = {0.06, 0.4};  ///< of the circle around the contact
  std::pair<double, double> aspect = {0.4, 1};     ///< shorter axis or side over longer
  std::pair<int, int> corners = {3, 8};            ///< of a polygon
  std::pair<double, double> conductivity_ratio = {0.1, 0.9};
  double blank_fraction = 0;  ///< share of scenes without a contact
  bool inside = true;  ///< the circle around each contact lies in the sheet; else its centre does

  Scene draw(RandomStream& random) const;
};

/// Reads `{"contacts", "shapes", "radius", "aspect", "corners", "conductivity_ratio",
/// "blank_fraction", "placement"}`; an interval is [low, high] or one number.
SceneDistribution scene_distribution_from_json(JsonObject object);
nlohmann::json to_json(const SceneDistribution& distribution);

}  // namespace ertbench
