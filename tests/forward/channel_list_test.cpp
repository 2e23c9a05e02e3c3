// Sensors whose channels are a list, held against a disc's closed form and against sensors of
// patterns.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <numeric>
#include <random>

#include "core/errors.h"
#include "core/files.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/sensor_json.h"
#include "tests/forward/closed_form_disc.h"
#include "tests/forward/sensors_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using Eigen::Index;
using Eigen::VectorXd;
using nlohmann::json;

/// Channels of four electrodes drawn at random, [a, b, m, n] from 0.
json random_channels(int count, int electrodes) {
  std::mt19937 random(5);
  std::vector<int> all(static_cast<std::size_t>(electrodes));
  std::iota(all.begin(), all.end(), 0);
  json list = json::array();
  for (int c = 0; c < count; ++c) {
    std::shuffle(all.begin(), all.end(), random);
    list.push_back({all[0], all[1], all[2], all[3]});
  }
  return list;
}

Sensor disc_of(const json& list, json more = json::object()) {
  more["channels"] = list;
  more["count_from"] = 0;
  return testing::disc(more);
}

TEST(ChannelList, VoltagesAndSensitivityAreThoseOfTheClosedForm) {
  const std::complex<double> place(0.3, 0.4);
  for (const int count : {12, 300}) {  // fewer pairs than electrodes, and more
    Sensor sensor = disc_of(random_channels(count, 32), {{"electrode_count", 32}});
    std::vector<double> currents;
    for (int d = 0; d < sensor.drives(); ++d) currents.push_back(0.001 * (1 + d % 3));
    sensor.set_currents(currents);
    ClosedFormDisc exact(32, 90, true);
    exact.conductivity = sensor.background;
    const BorderModel model(sensor);
    Contact disc;
    disc.centre = {0.3, 0.4};
    disc.half_size = {0.01, 0.01};
    disc.conductivity_ratio = 0.5;
    const VectorXd change = model.solve_at({{disc}}, 2).change;
    const VectorXd density = border_sensitivity(sensor, {Eigen::Vector2d(0.3, 0.4)});
    const auto channels = channels_of(sensor);
    const auto electrodes = electrodes_of_channels(sensor);
    VectorXd wanted(count);
    VectorXd wanted_change(count);
    for (Index c = 0; c < count; ++c) {
      const auto i = static_cast<std::size_t>(c);
      exact.current = currents[static_cast<std::size_t>(channels[i].drive)];
      wanted[c] = exact.voltage(electrodes[i]);
      wanted_change[c] = exact.voltage(electrodes[i], {{place, 0.01, 0.5}}) - wanted[c];
    }
    EXPECT_LT((model.reference_voltages() - wanted).norm(), 1e-10 * wanted.norm());
    // Of first order in the area, with errors of its square.
    EXPECT_LT((change - wanted_change).norm(), 1e-3 * wanted_change.norm());
    const double polarised =
        2 * (0.5 - 1) / (0.5 + 1) * sensor.background * std::numbers::pi * 0.01 * 0.01;
    EXPECT_LT((polarised * density - wanted_change).norm(), 1e-10 * wanted_change.norm());
  }
}

TEST(ChannelList, OfAPatternsChannelsIsAPartOfThePattern) {
  const Sensor whole;
  const auto electrodes = electrodes_of_channels(whole);
  std::vector<ChannelElectrodes> some;
  std::vector<int> kept;
  for (int c = 3; c < 208; c += 2 + c % 3) {
    kept.push_back(c);
    some.push_back(electrodes[static_cast<std::size_t>(c)]);
    if (c % 2 == 0) std::swap(some.back().measurement.first, some.back().measurement.second);
  }
  const Sensor sensor = with_channels(whole, some);
  EXPECT_EQ(sensor.channels(), std::ssize(kept));
  VectorXd sign = VectorXd::Ones(sensor.channels());
  for (Index c = 0; c < sign.size(); ++c) {
    if (kept[static_cast<std::size_t>(c)] % 2 == 0) sign[c] = -1;  // reversed pairs
  }
  const RowMajorMatrix wanted = ForwardModel(whole, 24).jacobian()(kept, Eigen::all);
  const RowMajorMatrix found = ForwardModel(sensor, 24).jacobian();
  EXPECT_LT((sign.asDiagonal() * found - wanted).norm(), 1e-12 * wanted.norm());
  const RowMajorMatrix of_border = border_jacobian(whole)(kept, Eigen::all);
  EXPECT_LT((sign.asDiagonal() * border_jacobian(sensor) - of_border).norm(),
            1e-12 * of_border.norm());
  EXPECT_EQ(symmetries(sensor).size(), 1u);
}

TEST(ChannelList, ReciprocalPairsAreFoundWhereverTheyAre) {
  const json list = {{0, 1, 2, 3}, {5, 9, 2, 3}, {2, 3, 0, 1}, {4, 5, 6, 7},
                     {7, 6, 5, 4}, {6, 7, 8, 9}, {9, 8, 6, 7}};
  const std::vector<std::array<int, 2>> pairs = {{0, 2}, {3, 4}, {1, 1}, {5, 5}, {6, 6}};
  EXPECT_EQ(reciprocal_pairs(disc_of(list)), pairs);
  // Not between drives of different currents.
  json currents = {1e-3, 1e-3, 2e-3, 1e-3, 1e-3, 1e-3, 1e-3};
  EXPECT_EQ(reciprocal_pairs(disc_of(list, {{"drive_currents", currents}})).size(), 6u);
}

TEST(ChannelList, IsReadFromAFileAndFromOne) {
  const TemporaryFolder folder("channels");
  std::ofstream(folder / "list.txt") << "# a b m n\n1 2 3 4\n5,6,7,8\n\n16 1\t9 10\n2 1 9 12\n";
  std::ofstream(folder / "sensor.json")
      << R"({"channels": "list.txt", "drive_currents": [0.001, 0.002, 0.003, 0.004]})";
  const Sensor sensor = read_sensor(folder / "sensor.json");
  EXPECT_EQ(sensor.channels(), 4);
  EXPECT_EQ(electrodes_of_channels(sensor)[2], (ChannelElectrodes{{15, 0}, {8, 9}}));
  EXPECT_EQ(sensor.current_of(2), 0.003);
  EXPECT_TRUE(sensor_of(to_json(sensor)) == sensor);
  // An experiment elsewhere gets the list itself.
  EXPECT_TRUE(sensor_of(read_sensor_json(folder / "sensor.json")) == sensor);
  const Sensor fewer = with_channels(
      sensor, {{{15, 0}, {8, 9}}, {{15, 0}, {8, 10}}, {{4, 5}, {8, 9}}, {{4, 5}, {9, 10}}});
  EXPECT_EQ(fewer.drive_currents, (std::vector<double>{0.003, 0.002}));
  EXPECT_TRUE(sensor_of(to_json(fewer)) == fewer);
}

TEST(ChannelList, ThatCannotBeIsRefused) {
  const json good = {{1, 2, 3, 4}, {2, 3, 4, 5}, {3, 4, 5, 6}, {4, 5, 6, 7}};
  const auto with = [&](const json& last) {
    json list = good;
    list.push_back(last);
    return list;
  };
  const std::vector<std::pair<json, const char*>> wrong = {
      {{{"channels", good}}, "count_from"},
      {{{"channels", with({16, 1, 2, 3})}, {"count_from", 0}}, "1 to 16; counted from 0"},
      {{{"channels", with({0, 1, 2, 3})}, {"count_from", 1}}, "counted from 1"},
      {{{"channels", with({0, 16, 2, 3})}}, "0 to 16"},
      {{{"channels", with({0, 1, 1, 2})}}, "driven point"},
      {{{"channels", with({0, 0, 1, 2})}}, "itself"},
      {{{"channels", with({2, 3, 4, 5})}, {"count_from", 0}}, "the same as channel 1"},
      {{{"channels", with({0, 1, 2})}}, "[a, b, m, n]"},
      {{{"channels", {{0, 1, 2, 3}}}}, "4 to 4096"},
      {{{"channels", "absent.txt"}}, "cannot be opened"},
      {{{"channels", with({0, 1, 2, 3})}, {"drive", "opposite"}}, "remove one of the two"},
      {{{"drive_currents", {1, 2}}}, "array of 16 numbers"},
      {{{"drive_currents", json(16, 0.1)}, {"drive_current", 0.1}}, "remove one of the two"}};
  for (const auto& [keys, message] : wrong) {
    try {
      sensor_of(keys);
      ADD_FAILURE() << "not refused: " << keys;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(message), std::string::npos) << error.what();
    }
  }
}

TEST(Sensor, FirstElectrodeMayBeAnywhereOnTheBorder) {
  for (const double turns : {0.5, -0.5, 2.5}) {
    const Sensor sensor = testing::disc({{"electrode_offset_mm", turns * 200 * std::numbers::pi}});
    EXPECT_LT((electrode_positions(sensor).col(0) - Eigen::Vector2d(0, -1)).norm(), 1e-9) << turns;
    EXPECT_TRUE(sensor_of(to_json(sensor)) == sensor);
    EXPECT_EQ(symmetries(sensor).size(), 8u);
  }
}

}  // namespace
}  // namespace ertbench
