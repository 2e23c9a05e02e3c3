// What a sensor's description comes to: channels, electrodes' places, refusals.

#include "forward/sheet/sensor_json.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "tests/forward/sensors_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using Eigen::Index;
using nlohmann::json;

TEST(Channels, OfPatternsAreThoseThatShareNoDrivenElectrode) {
  EXPECT_EQ(disc().channels(), 208);
  EXPECT_EQ(disc({{"drive", "opposite"}}).channels(), 192);
  EXPECT_EQ(reciprocal_pairs(disc({{"drive", "opposite"}})).size(), 192);
  EXPECT_EQ(disc({{"drive", {{"skip", 2}}}}).channels(), 208);
  EXPECT_EQ(reciprocal_pairs(disc({{"drive", {{"skip", 2}}}})).size(), 104);
  EXPECT_EQ(rectangle().channels(), 928);
  EXPECT_EQ(disc({{"measures_driven", true}, {"electrode_model", "gap"}, {"electrode_width", 0.1}})
                .channels(),
            256);
}

TEST(Sensor, IsWhatItsFileSays) {
  for (const char* name : {"d2s", "rectangle_32", "disc_16", "tank", "skin_opposite"}) {
    const Sensor sensor = read_sensor(std::filesystem::path(ERTBENCH_SOURCE_DIR) / "sensors" /
                                      (std::string(name) + ".json"));
    EXPECT_TRUE(sensor_of(to_json(sensor)) == sensor) << name;
  }
  EXPECT_TRUE(read_sensor(std::filesystem::path(ERTBENCH_SOURCE_DIR) / "sensors/d2s.json") ==
              Sensor{});
}

TEST(Sensor, PlacesItsElectrodesAsListed) {
  const Sensor equal = disc();
  json points = json::array();
  const Eigen::Matrix2Xd positions = electrode_positions(equal);
  for (Index e = 0; e < positions.cols(); ++e) {
    points.push_back({100 * positions(0, e), 100 * positions(1, e)});
  }
  const Sensor listed = disc({{"electrode_points_mm", points}});
  EXPECT_LT((electrode_positions(listed) - positions).norm(), 1e-6);
  const Sensor turned = disc({{"counterclockwise", true}});
  EXPECT_LT((electrode_positions(turned).col(1) - positions.col(15)).norm(), 1e-12);
  EXPECT_LT((electrode_positions(turned).col(0) - positions.col(0)).norm(), 1e-12);
}

TEST(Sensor, RefusesWhatCannotBe) {
  const std::vector<std::pair<json, const char*>> wrong = {
      {{{"shape", "rectangle"}, {"sides_mm", {1000, 100}}}, "5 to 1"},
      {{{"shape", "disc"}}, "diameter_mm"},
      {{{"contact_impedance", 1}}, "point electrodes"},
      {{{"electrode_model", "gap"}, {"electrode_width", 0.6}}, "room between"},
      {{{"measures_driven", true}}, "infinite"},
      {{{"electrode_count", 15}, {"drive", "opposite"}}, "even number"},
      {{{"drive", {{0, 16}}}}, "from 0 to 15"},
      {{{"electrode_places", {0, 1, 2, 3, 3}}}, "same place"},
      {{{"electrode_points_mm", {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}}}},
       "on the sheet's border"}};
  for (const auto& [value, part] : wrong) {
    try {
      sensor_of(value);
      ADD_FAILURE() << value;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace ertbench
