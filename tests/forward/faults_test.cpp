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

TEST(Faults, HalfDeadAndLooseElectrodesReadHalfOrNowAndThenNothing) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  const auto with = [](const char* reading) {
    return block_of(spec_of({{"dead_electrodes", 1}, {"dead_reading", reading}})).voltages;
  };
  const Frames zero = with("zero");
  const Frames half = with("half");
  const Frames loose = with("intermittent");
  int nothing = 0;
  for (Eigen::Index i = 0; i < whole.size(); ++i) {
    const bool dead = zero.data()[i] == 0;
    EXPECT_EQ(half.data()[i], (dead ? 0.5 : 1) * whole.data()[i]);
    EXPECT_TRUE(loose.data()[i] == whole.data()[i] || (dead && loose.data()[i] == 0));
    nothing += loose.data()[i] == 0;
  }
  // 12 frames of 52 channels each with chance one half, within 4 deviations.
  EXPECT_NEAR(nothing, 12 * 26, 4 * std::sqrt(12 * 52 / 4.0));
}

TEST(Faults, HumIsASineOfItsSizeInTheOrderOfTheChannels) {
  const Frames whole = block_of(spec_of(nlohmann::json::object())).voltages;
  const Frames hum = block_of(spec_of({{"hum", 0.01}})).voltages - whole;
  const double rms = ForwardModel(Sensor{}, 48).reference_voltages().norm() / std::sqrt(208.0);
  for (const auto& frame : hum.rowwise()) {
    // Of a sine x[n - 1] + x[n + 1] = 2 cos(w) x[n], with one w for all n.
    const Eigen::ArrayXd x = frame.transpose().array();
    const Eigen::ArrayXd ends = x.head(206) + x.tail(206);
    const Eigen::ArrayXd middle = x.segment(1, 206);
    const double twice_cosine = (ends * middle).sum() / middle.square().sum();
    EXPECT_LT((ends - twice_cosine * middle).abs().maxCoeff(), 1e-9 * rms);
    EXPECT_LE(x.abs().maxCoeff(), 0.01 * std::sqrt(2.0) * rms * (1 + 1e-12));
  }
}

TEST(Faults, SettlingMixesTheChangesOfNeighbouringChannels) {
  const VectorXd reference = ForwardModel(Sensor{}, 48).reference_voltages();
  const Frames whole =
      block_of(spec_of(nlohmann::json::object())).voltages.rowwise() - reference.transpose();
  const Frames mixed =
      block_of(spec_of({{"settling", 0.1}})).voltages.rowwise() - reference.transpose();
  const Frames expected = 0.9 * whole.rightCols(207) + 0.1 * whole.leftCols(207);
  EXPECT_LT((mixed.rightCols(207) - expected).norm(), 1e-12 * whole.norm());
}

TEST(Faults, NoiseByChannelKeepsTheFramesSnr) {
  const Frames clean = block_of(spec_of(nlohmann::json::object())).voltages;
  const auto noise = [&](double spread) -> Frames {
    DatasetSpec spec = spec_of(nlohmann::json::object(), 50);
    spec.noise.spread = spread;
    return block_of(spec).voltages - clean;
  };
  const Frames even = noise(0);
  const Frames spread = noise(1);
  for (Eigen::Index f = 0; f < clean.rows(); ++f) {
    EXPECT_NEAR(spread.row(f).norm() / even.row(f).norm(), 1, 1e-9);
  }
  // The fourth moment of u exp(v) over that of u, relative to the squared second, is exp(4).
  const auto kurtosis = [](const Frames& x) {
    return x.array().square().square().mean() / std::pow(x.array().square().mean(), 2);
  };
  EXPECT_NEAR(kurtosis(even), 3, 0.4);
  EXPECT_GT(kurtosis(spread), 10);
}

TEST(Faults, MottledFilmsHaveTheirDeviationAndCancelWithTheirReference) {
  const PixelGrid pixels = square_sheet()->pixels(48);
  double mean = 0;
  double square = 0;
  double beside = 0;
  double across = 0;
  constexpr int films = 60;
  for (std::uint64_t f = 0; f < films; ++f) {
    RandomStream random(1, 2, f, Purpose::gradient);
    const Eigen::ArrayXd film =
        mottle_factors({.background_mottle = 0.1}, *square_sheet(), pixels, random).array() - 1;
    mean += film.mean() / films;
    square += film.square().mean() / films;
    // Gaussian correlation over sqrt(2) / 4, in pixels of 1/24; and 1.5 units away.
    const Eigen::Map<const Eigen::ArrayXXd> map(film.data(), 48, 48);
    beside += (map.topRows(40) * map.bottomRows(40)).mean() / films;
    across += (map.topRows(12) * map.bottomRows(12)).mean() / films;
  }
  EXPECT_NEAR(mean, 0, 0.02);
  EXPECT_NEAR(std::sqrt(square), 0.1, 0.01);
  EXPECT_NEAR(beside / square, std::exp(-std::pow(8.0 / 24 / (std::sqrt(2.0) / 4), 2) / 2), 0.1);
  EXPECT_NEAR(across / square, 0, 0.15);

  // An untouched mottled sheet whose reference is its own shows nothing.
  DatasetSpec spec = spec_of({{"background_mottle", 0.2}});
  spec.scenes = std::vector<Scene>(12);
  const VectorXd reference = ForwardModel(Sensor{}, 48).reference_voltages();
  EXPECT_LT((block_of(spec).clean_voltages.rowwise() - reference.transpose()).norm(),
            1e-9 * reference.norm());
  spec.faults.displacement_reference = DisplacementReference::stale;
  EXPECT_GT((block_of(spec).clean_voltages.rowwise() - reference.transpose()).norm(),
            1e-2 * reference.norm());
}

DatasetSpec continuous_spec(const nlohmann::json& faults) {
  DatasetSpec spec = spec_of(nlohmann::json::object());
  spec.model = ContinuousSheet{};
  spec.scenes = std::vector<Scene>(6);
  spec.count = 6;
  spec.faults = faults_from_json(JsonObject(faults, "test", ""), spec.sensor, spec.model);
  return spec;
}

TEST(Faults, GradientsOfTheContinuousSheetAreThoseOfTheGridToFirstOrder) {
  DatasetSpec on_grid = spec_of({{"background_gradient", 0.1}});
  on_grid.scenes = std::vector<Scene>(6);
  on_grid.count = 6;
  const auto changes = [](const DatasetSpec& spec) -> Frames {
    const SceneModel model(spec.sensor, spec.model);
    return generate_block(spec, model, 0, 6).clean_voltages.rowwise() -
           model.reference_voltages().transpose();
  };
  const Frames exact = changes(on_grid);
  EXPECT_LT((changes(continuous_spec({{"background_gradient", 0.1}})) - exact).norm(),
            0.1 * exact.norm());
}

TEST(Faults, ContactImpedancesAndWidthsChangeAnEmptySheetOnlyWithoutAReferenceOfTheirs) {
  const SceneModel model(Sensor{}, ContinuousSheet{});
  for (const char* fault : {"electrode_width", "impedance_drift"}) {
    nlohmann::json faults = {{fault, 0.05}};
    const auto change = [&] {
      return (generate_block(continuous_spec(faults), model, 0, 6).clean_voltages.rowwise() -
              model.reference_voltages().transpose())
          .norm();
    };
    EXPECT_LT(change(), 1e-12);
    faults["displacement_reference"] = "stale";
    // All electrodes of one width are the same as before; impedances that drift are not.
    if (std::string(fault) == "impedance_drift") {
      EXPECT_GT(change(), 1e-5);
    }
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
  EXPECT_NE(faults_refusal({{"impedance_drift", 0.1}}).find("needs \"grid\": \"auto\""),
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
