// Frames as other instruments give them, from a disc's closed form to the place in the image.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "core/hdf5_file.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"
#include "tests/forward/closed_form_disc.h"

namespace ertbench::testing {
namespace {

constexpr double radius_mm = 100;
constexpr double near_mm = 8;
constexpr int empty_frames = 4;

std::vector<ChannelElectrodes> patterned(int electrodes, int drive_step, int measuring_step,
                                         const std::function<bool(int, int)>& is_measured) {
  std::vector<ChannelElectrodes> out;
  for (int d = 0; d < electrodes; ++d) {
    for (int m = 0; m < electrodes; ++m) {
      const ChannelElectrodes channel = {{d, (d + drive_step) % electrodes},
                                         {m, (m + measuring_step) % electrodes}};
      const auto [a, b] = channel.drive;
      const auto [p, q] = channel.measurement;
      if (p != a && p != b && q != a && q != b && is_measured(d, m)) out.push_back(channel);
    }
  }
  return out;
}

bool always(int, int) { return true; }

/// A recording of a disc: frames without contact, then one of a worse conductor at `place_mm`.
struct Recording {
  ClosedFormDisc sheet{16, 90, true};
  std::vector<ChannelElectrodes> channels = patterned(16, 1, 1, always);
  Eigen::Vector2d place_mm = {30, 30};
  /// What the instrument writes for a channel's volts.
  std::function<double(std::size_t channel, double volts)> written = [](std::size_t, double v) {
    return v;
  };

  void write(const fs::path& file) const {
    std::ofstream out(file);
    out.precision(10);
    const std::complex<double> at(place_mm.x() / radius_mm, place_mm.y() / radius_mm);
    for (int f = 0; f <= empty_frames; ++f) {
      std::vector<ClosedFormDisc::Inclusion> inclusions;
      if (f == empty_frames) inclusions.push_back({at, 0.15, 0.5});
      for (std::size_t c = 0; c < channels.size(); ++c) {
        out << (c > 0 ? "," : "") << written(c, sheet.voltage(channels[c], inclusions));
      }
      out << '\n';
    }
  }
  void write_list(const fs::path& file) const {
    std::ofstream out(file);
    for (const auto& [drive, measurement] : channels) {
      out << drive.first + 1 << ' ' << drive.second + 1 << ' ' << measurement.first + 1 << ' '
          << measurement.second + 1 << '\n';
    }
  }
};

constexpr const char* sensor_16 =
    R"({"shape": "disc", "diameter_mm": 200, "drive_current": 1, "background": 1})";

class ForeignFrames : public ::testing::Test {
 protected:
  ForeignFrames() {
    write_text(folder_ / "gn.json", R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.03})");
  }

  Outcome reconstruct(const Recording& recording, const std::string& sensor,
                      const std::string& options = "") {
    recording.write(folder_ / "frames.csv");
    write_text(folder_ / "sensor.json", sensor);
    return run_program(folder_.path(),
                       "reconstruct --solver gn.json --sensor sensor.json --input frames.csv "
                       "--background 0-3 --output images.h5 " +
                           options);
  }

  /// The centroid of the last image's pixels above half of its strongest, mm.
  Eigen::Vector2d place() const {
    const Hdf5File file = Hdf5File::open(folder_ / "images.h5");
    const Eigen::VectorXd x = file.read_vector("/x_mm");
    const Eigen::VectorXd y = file.read_vector("/y_mm");
    const Eigen::RowVectorXd image = file.read_rows("/conductivity_change", empty_frames, 1).row(0);
    EXPECT_LT(image.minCoeff(), -2 * image.maxCoeff()) << "conductivity falls";
    Eigen::Vector2d sum(0, 0);
    double weight = 0;
    for (Eigen::Index p = 0; p < image.size(); ++p) {
      if (image[p] > image.minCoeff() / 2) continue;
      sum += image[p] * Eigen::Vector2d(x[p % x.size()], y[p / x.size()]);
      weight += image[p];
    }
    return sum / weight;
  }

  void expect_place(const Recording& recording) const {
    EXPECT_LT((place() - recording.place_mm).norm(), near_mm) << place().transpose();
  }

  TemporaryFolder folder_{"foreign"};
};

TEST_F(ForeignFrames, OfAListOfChannelsAreReadAsTheyAre) {
  Recording recording;
  recording.sheet = ClosedFormDisc(32, 180, true);
  recording.place_mm = {30, 40};
  recording.channels.clear();
  std::mt19937 random(4);
  std::vector<int> all(32);
  for (int e = 0; e < 32; ++e) all[static_cast<std::size_t>(e)] = e;
  for (int c = 0; c < 300; ++c) {
    std::shuffle(all.begin(), all.end(), random);
    recording.channels.push_back({{all[0], all[1]}, {all[2], all[3]}});
  }
  recording.write_list(folder_ / "list.txt");
  const std::string sensor =
      R"({"shape": "disc", "diameter_mm": 200, "electrode_count": 32, "drive_current": 1,
          "background": 1, "electrode_offset_mm": 471.2389)";
  const Outcome named = reconstruct(recording, sensor + R"(, "channels": "list.txt"})");
  ASSERT_EQ(named.exit_code, 0) << named.output;
  expect_place(recording);
  const Outcome as_order = reconstruct(recording, sensor + "}", "--channels list.txt");
  ASSERT_EQ(as_order.exit_code, 0) << as_order.output;
  expect_place(recording);
}

TEST_F(ForeignFrames, OfAPartOfAPatternAreReadAsTheyAre) {
  Recording recording;
  recording.sheet = ClosedFormDisc(32, 90, false);
  recording.place_mm = {40, -30};
  recording.channels = patterned(32, 5, 5, [](int d, int m) {
    const int apart = (m - d + 32) % 32;
    return apart != 1 && apart != 31 && apart != 4 && apart != 6;
  });
  recording.write_list(folder_ / "list.txt");
  const Outcome outcome = reconstruct(
      recording,
      R"({"shape": "disc", "diameter_mm": 200, "electrode_count": 32, "counterclockwise": true,
          "drive_current": 1, "background": 1, "channels": "list.txt", "count_from": 1})");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  expect_place(recording);
}

TEST_F(ForeignFrames, MissChannelsThatNoFrameHas) {
  Recording recording;
  recording.written = [&](std::size_t c, double volts) {
    const auto& [drive, measurement] = recording.channels[c];
    const bool missing =
        drive.first == 5 || drive.second == 5 || measurement.first == 5 || measurement.second == 5;
    return missing ? std::numeric_limits<double>::quiet_NaN() : volts;
  };
  const Outcome outcome = reconstruct(recording, sensor_16);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("52 channels have no number in any frame (those of electrode 5"),
            std::string::npos)
      << outcome.output;
  expect_place(recording);
  EXPECT_EQ(Hdf5File::open(folder_ / "images.h5").shape("/channel_map")[0], 156u);
}

TEST_F(ForeignFrames, WithGainsOfEachChannelAreImagedByTheirRatio) {
  Recording recording;
  recording.place_mm = {-50, 20};
  recording.written = [](std::size_t c, double volts) {
    return std::abs(volts) * (1 + static_cast<double>((c * c * 7) % 23) / 5);
  };
  const Outcome refused = reconstruct(recording, sensor_16);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.output.find("--difference normalised"), std::string::npos) << refused.output;
  for (const char* option : {"--difference normalised", "--fix"}) {
    const Outcome outcome = reconstruct(recording, sensor_16, option);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    expect_place(recording);
  }
}

TEST_F(ForeignFrames, WithZerosWhereOthersMeasureTheSameAreRead) {
  Recording recording;
  recording.place_mm = {-30, -50};
  recording.channels.clear();
  for (int d = 0; d < 16; ++d) {
    for (int m = 0; m < 16; ++m)
      recording.channels.push_back({{d, (d + 8) % 16}, {m, (m + 1) % 16}});
  }
  recording.written = [&](std::size_t c, double volts) {
    const auto& [drive, measurement] = recording.channels[c];
    const bool driven =
        measurement.first % 8 == drive.first % 8 || measurement.second % 8 == drive.first % 8;
    return driven || drive.first >= 8 ? 0 : 1e3 * std::abs(volts);
  };
  const std::string sensor =
      R"({"shape": "disc", "diameter_mm": 200, "drive": "opposite", "measurement": "adjacent",
          "drive_current": 1, "background": 1})";
  const Outcome outcome = reconstruct(recording, sensor, "--fix");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("96 channels are 0 in every frame"), std::string::npos)
      << outcome.output;
  EXPECT_NE(outcome.output.find("millivolts"), std::string::npos) << outcome.output;
  expect_place(recording);
}

TEST_F(ForeignFrames, MayBeginAnywhereOnTheBorder) {
  Recording recording;
  recording.sheet = ClosedFormDisc(16, 270, true);
  recording.place_mm = {55, 0};
  const Outcome outcome = reconstruct(
      recording, R"({"shape": "disc", "diameter_mm": 200, "electrode_offset_mm": 314.159265,
                     "drive_current": 1, "background": 1})");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  expect_place(recording);
}

TEST_F(ForeignFrames, AreExplainedByContactsWithTheNoiseOfTheBackground) {
  // The noise is taken as a share of the reference.
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 2e-4);
  Recording recording;
  recording.written = [&](std::size_t, double volts) { return 1e3 * (volts + noise(random)); };
  write_text(folder_ / "gn.json", R"({"type": "contacts"})");
  const Outcome outcome = reconstruct(recording, sensor_16, "--unit mV");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const Hdf5File images = Hdf5File::open(folder_ / "images.h5");
  const Eigen::RowVectorXd first = images.read_rows("/contacts", empty_frames, 1, true).row(0);
  EXPECT_LT((first.head<2>().transpose() - recording.place_mm).norm(), 2) << first.head<3>();
  EXPECT_TRUE(std::isnan(images.read_rows("/contacts", 0, 1, true)(0, 0))) << "an empty frame";
  const nlohmann::json solver = nlohmann::json::parse(images.read_text("/", "solver"));
  EXPECT_NEAR(solver.at("noise").get<double>(), 2e-4, 3e-5);
  EXPECT_EQ(solver.at("prior_weight"), 1);
}

}  // namespace
}  // namespace ertbench::testing
