#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "core/random.h"
#include "forward/data/contact_draw.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

class JsonObject;

/// Random scenes. Every quantity is drawn uniformly and independently from its interval.
struct SceneDistribution {
  std::pair<int, int> contacts = {1, 3};  ///< contacts in a scene
  std::vector<DrawnShape> shapes = {DrawnShape::disc, DrawnShape::ellipse, DrawnShape::rectangle,
                                    DrawnShape::polygon};
  std::pair<double, double> radius = {0.06, 0.4};  ///< of the circle around the contact
  std::pair<double, double> aspect = {0.4, 1};     ///< shorter axis or side over longer
  std::pair<int, int> corners = {3, 8};            ///< of a polygon
  std::pair<double, double> conductivity_ratio = {0.1, 0.9};
  double blank_fraction = 0;  ///< share of scenes without a contact
  bool inside = true;  ///< the circle around each contact lies in the sheet; else its centre does
  /// Where the centres are, x and y; given, `inside` means nothing.
  std::optional<std::pair<std::pair<double, double>, std::pair<double, double>>> centre;
  /// From the border of the circle around the first contact to that around the second, in a random
  /// direction, both inside the sheet; of two contacts alone.
  std::optional<std::pair<double, double>> gap;

  /// Takes the same random numbers for the same contacts whatever the intervals, so that scenes of
  /// two distributions that differ in one interval are paired.
  Scene draw(RandomStream& random, const Sheet& sheet) const;
  /// The contacts as they are drawn, each independently of the others, before a `gap` moves them.
  std::vector<ContactDraw> draw_contacts(RandomStream& random, const Sheet& sheet) const;
  ContactDraw draw_contact(RandomStream& random, const Sheet& sheet) const;
  std::size_t most_vertices() const;  ///< of one contact, 0 where there are no polygons
};

/// Reads `{"contacts", "shapes", "radius", "aspect", "corners", "conductivity_ratio",
/// "blank_fraction", "placement", "centre": {"x", "y"}, "gap"}`; an interval is [low, high] or one
/// number. Lengths and places may stand in millimetres: `radius_mm`, `x_mm`, ... (SheetLengths).
SceneDistribution scene_distribution_from_json(JsonObject object, const Sheet& sheet);
nlohmann::json to_json(const SceneDistribution& distribution);

}  // namespace ertbench
