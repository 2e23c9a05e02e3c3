#include "forward/data/faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/errors.h"
#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/dataset_spec.h"
#include "forward/data/scene_model.h"
#include "forward/fem/forward_model.h"

namespace ertbench {
namespace {

using Eigen::VectorXd;

DatasetSpec spec_of(nlohmann::json faults, nlohmann::json snr_db = nullptr) {
  nlohmann::json object = {{"count", 12},
                           {"seed", 5},
                           {"grid", 48},
                           {"snr_db", snr_db},
                           {"snr_basis", "absolute"},
                           {"faults", std::move(faults)},
                           {"scenes", nlohmann::json::object()}};
  return dataset_spec_from_json(JsonObject(object, "test", ""), Sensor{}, "test");
}

DatasetBlock block_of(const DatasetSpec& spec) {
  return generate_block(spec, SceneModel(spec.sensor, spec.model), 0, spec.count);
}

std::string faults_refusal(const nlohmann::json& faults) {
  try {
    spec_of(faults);
  } catch (const InputError& e) {
    return e.what();
  }
  return "accepted";
}

/// Channels that read exactly 0 V, in one frame.
std::set<int> zeros(const Eigen::RowVectorXd& frame) {
  std::set<int> out;
  for (int c = 0; c < frame.size(); ++c) {
    if (frame[c] == 0) out.insert(c);
  }
  return out;
}

TEST(Faults, OffLeaveTheRecipeAlone) {
  const nlohmann::json recipe = to_json(spec_of(nlohmann::json::object()));
  EXPECT_FALSE(recipe.contains("faults"));
  EXPECT_EQ(to_json(spec_of({{"dead_electrodes", 0}, {"dead_reading", "floating"}})), recipe);
  EXPECT_EQ(to_json(spec_of({{"gain_error", 0.1}})).at("faults"),
            nlohmann::json({{"gain_error", 0.1}}));
}

TEST(Faults, DeadElectrodesOfLessAreAmongThoseOfMore) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  std::vector<std::set<int>> before(12);
  for (int dead = 1; dead <= 4; ++dead) {
    const Frames frames = block_of(spec_of({{"dead_electrodes", dead}})).voltages;
    for (Eigen::Index i = 0; i < frames.rows(); ++i) {
      std::set<int>& previous = before[static_cast<std::size_t>(i)];
      const std::set<int> now = zeros(frames.row(i));
      EXPECT_TRUE(std::includes(now.begin(), now.end(), previous.begin(), previous.end()));
      EXPECT_TRUE(dead == 3 || dead == 4 || now.size() > previous.size())
          << "an electrode between two dead ones takes nothing with it";
      if (dead == 1) {
        // Two drives and two measuring pairs of 13 channels each; none is of both, as a drive skips
        // the pairs that share its electrodes.
        EXPECT_EQ(now.size(), 52u);
      }
      for (int c = 0; c < frames.cols(); ++c) {
        EXPECT_TRUE(now.contains(c) || frames(i, c) == whole(i, c));
      }
      previous = now;
    }
  }
}

TEST(Faults, FloatingChannelsShowNoiseOfTheFramesStrength) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  const Frames frames =
      block_of(spec_of({{"dead_electrodes", 2}, {"dead_reading", "floating"}})).voltages;
  double ratio = 0;
  int count = 0;
  for (Eigen::Index i = 0; i < frames.rows(); ++i) {
    const double mean_square = whole.row(i).squaredNorm() / 208;
    for (Eigen::Index c = 0; c < frames.cols(); ++c) {
      if (frames(i, c) == whole(i, c)) continue;
      ratio += frames(i, c) * frames(i, c) / mean_square;
      ++count;
    }
  }
  // The mean of n squares of standard normals lies within 4 sqrt(2 / n) of 1.
  EXPECT_NEAR(ratio / count, 1, 4 * std::sqrt(2.0 / count));
}

TEST(Faults, GainsAndOffsetsBelongToMeasuringPairsAndScale) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  const Frames gain = block_of(spec_of({{"gain_error", 0.1}})).voltages;
  const Frames twice = block_of(spec_of({{"gain_error", 0.2}})).voltages;
  const Frames offset = block_of(spec_of({{"offset", 0.01}})).voltages;
  const std::vector<Channel> channels = channels_of(Sensor{});
  const ForwardModel model(Sensor{}, 48);
  const double rms = model.reference_voltages().norm() / std::sqrt(208.0);
  for (Eigen::Index i = 0; i < whole.rows(); ++i) {
    std::map<int, double> gains;
    std::map<int, double> offsets;
    for (Eigen::Index c = 0; c < whole.cols(); ++c) {
      const int pair = channels[static_cast<std::size_t>(c)].measurement;
      const double g = gain(i, c) / whole(i, c) - 1;
      EXPECT_LE(std::abs(g), 0.1 + 1e-12);
      EXPECT_NEAR(gains.emplace(pair, g).first->second, g, 1e-12);
      EXPECT_NEAR(twice(i, c) / whole(i, c) - 1, 2 * g, 1e-12);
      const double o = (offset(i, c) - whole(i, c)) / rms;
      EXPECT_LE(std::abs(o), 0.01 + 1e-12);
      EXPECT_NEAR(offsets.emplace(pair, o).first->second, o, 1e-12);
    }
    EXPECT_EQ(gains.size(), 16u);
  }
}

TEST(Faults, ConverterRoundsFrameAndReference) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  const Frames rounded = block_of(spec_of({{"adc_bits", 8}})).voltages;
  const VectorXd reference = ForwardModel(Sensor{}, 48).reference_voltages();
  const double step = 2 * 1.25 * reference.cwiseAbs().maxCoeff() / 256;
  EXPECT_LE((rounded - whole).cwiseAbs().maxCoeff(), step / 2 * (1 + 1e-9));
  const VectorXd recorded = recorded_reference({.adc_bits = 8}, reference);
  for (const double voltage : recorded) {
    EXPECT_NEAR(voltage / step, std::round(voltage / step), 1e-9);
  }
  EXPECT_EQ(recorded_reference({.gain_error = 0.1}, reference), reference);
}

TEST(Faults, BackgroundDividesVoltagesAndKeepsTheTruth) {
  const DatasetBlock even = block_of(spec_of(nlohmann::json::object()));
  const DatasetBlock changed = block_of(spec_of({{"background_change", 0.2}}));
  EXPECT_LT((changed.clean_voltages * 1.2 - even.clean_voltages).norm(),
            1e-12 * even.clean_voltages.norm());
  EXPECT_EQ(changed.conductivity, even.conductivity);

  // A gradient is what the forward model makes of the image with that gradient.
  const DatasetSpec spec = spec_of({{"background_gradient", 0.3}});
  const DatasetBlock tilted = block_of(spec);
  EXPECT_EQ(tilted.conductivity, even.conductivity);
  RandomStream random = spec.stream(0, Purpose::gradient);
  const VectorXd factors =
      gradient_factors(spec.faults, *square_sheet(), square_sheet()->pixels(48), random);
  EXPECT_NEAR(factors.mean(), 1, 1e-12);
  EXPECT_LE((factors.array() - 1).abs().maxCoeff(), 0.3);
  EXPECT_GE((factors.array() - 1).abs().maxCoeff(), 0.3 / std::sqrt(2.0) * 47 / 48 - 1e-12);
  VectorXd ratio(48 * 48);
  rasterise(spec.scene(0), square_sheet()->pixels(48), Rasterisation::area, ratio);
  const Images sheet = 0.06 * (ratio.array() * factors.array()).transpose();
  EXPECT_LT((ForwardModel(Sensor{}, 48).solve(sheet) - tilted.clean_voltages.row(0)).norm(),
            1e-12 * tilted.clean_voltages.row(0).norm());
}

TEST(Faults, AreSmoothWhereNoiseIsDrawnBefore) {
  // The same noise at every level: the frames of a small gain differ little from those of none.
  const Frames none = block_of(spec_of(nlohmann::json::object(), 40)).voltages;
  const Frames little = block_of(spec_of({{"gain_error", 1e-9}}, 40)).voltages;
  EXPECT_LT((little - none).norm(), 1e-8 * none.norm());
}

TEST(Faults, SayWhatIsWrong) {
  EXPECT_NE(faults_refusal({{"dead_electrodes", 12}}).find("/faults/dead_electrodes"),
            std::string::npos);
  EXPECT_NE(faults_refusal({{"adc_bits", 1}}).find("must be 0 for no converter"),
            std::string::npos);
  EXPECT_NE(faults_refusal({{"electrode_displacement", 0.01}}).find("needs \"grid\": \"auto\""),
            std::string::npos);
  EXPECT_NE(faults_refusal({{"gain", 0.01}}).find("gain_error"), std::string::npos);
  const Faults displaced = {.electrode_displacement = 0.05};
  RandomStream random(1, 2, 3, Purpose::displacement);
  const VectorXd shift = displacements(displaced, Sensor{}, random);
  EXPECT_EQ(shift.size(), 16);
  EXPECT_LE(shift.cwiseAbs().maxCoeff(), 0.05);
  EXPECT_GT(shift.cwiseAbs().maxCoeff(), 0.02);
}

}  // namespace
}  // namespace ertbench
