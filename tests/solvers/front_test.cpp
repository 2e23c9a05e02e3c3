// What the front says of frames whose faults are known.

#include "solvers/front/front.h"

#include <gtest/gtest.h>

#include "core/hdf5_file.h"
#include "forward/border/border_model.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/sensor_json.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;

ElectrodeSet only(int electrode) { return ElectrodeSet{1} << electrode; }

/// `count` electrodes of which no two are neighbours.
ElectrodeSet electrodes_apart(int count, RandomStream& random) {
  ElectrodeSet out = random_electrodes(count, random);
  while (out & (out << 1 | out >> 15)) out = random_electrodes(count, random);
  return out;
}

class FrontOfFrames : public ::testing::Test {
 protected:
  static const Front& front() {
    static const ValidationFile validation(1000);
    static const Front front(Sensor{}, FrameCheck(validation.input(), 0),
                             {.level = 0.1, .gradient = 0.1, .electrodes = 0.02});
    return front;
  }
  static FrameState look(const Eigen::RowVectorXd& change) { return front().look(change.data()); }

  /// An untouched sheet at 50 dB.
  static Eigen::RowVectorXd blank(std::uint64_t seed) {
    RandomStream random(seed, 0, 0, Purpose::noise);
    Eigen::RowVectorXd out(208);
    const double size = uniform_reference({}).norm() / std::sqrt(208.0) / std::sqrt(1e5);
    for (double& value : out) value = size * random.normal();
    return out;
  }
  /// Channels of the electrode read a share of their voltage.
  static void read_share(Eigen::Ref<Eigen::RowVectorXd> frame, int electrode, double share) {
    for_dead_channels(frame, only(electrode), [&](double& change, double reference) {
      change = share * (change + reference) - reference;
    });
  }
};

// The front's constants were chosen on the scenes of the file's own seed.
TEST_F(FrontOfFrames, LetsSoundFramesOfHeldOutSeedsPass) {
  for (const std::uint64_t seed : {7001u, 7002u, 7003u}) {
    const Frames changes = fresh_changes(1000, 50, seed);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const FrameState state = look(changes.row(f));
      EXPECT_EQ(state.dead, ElectrodeSet{0}) << seed << " " << f;
      EXPECT_FALSE(state.saturated) << seed << " " << f;
    }
  }
}

TEST_F(FrontOfFrames, DetectsDeadElectrodesAndSaysHowTheyRead) {
  RandomStream random(1, 0, 0, Purpose::scene);
  const Frames changes = fresh_changes(10);
  for (int e = 0; e < 16; ++e) {
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      Eigen::RowVectorXd frame = changes.row(f);
      read_zero(frame, only(e));
      EXPECT_EQ(look(frame).dead, only(e));
      EXPECT_EQ(look(frame).floating, ElectrodeSet{0});
      frame = changes.row(f);
      read_noise(frame, only(e), random);
      EXPECT_EQ(look(frame).dead, only(e));
      EXPECT_EQ(look(frame).floating, only(e));
    }
  }
}

// Every second channel of theirs reads zero, at random. Which three or four they are several sets
// of electrodes may explain as well.
TEST_F(FrontOfFrames, NamesLooseElectrodes) {
  constexpr int least[] = {0, 190, 180, 150, 80};
  RandomStream random(3, 0, 0, Purpose::scene);
  const auto electrodes = electrode_sets_of_channels(Sensor{});
  const Eigen::VectorXd reference = uniform_reference({});
  for (const double snr : {50.0, 35.0}) {
    const Frames changes = fresh_changes(200, snr);
    for (int count = 1; count <= 4; ++count) {
      int found = 0;
      for (Eigen::Index f = 0; f < changes.rows(); ++f) {
        const ElectrodeSet bad = electrodes_apart(count, random);
        Eigen::RowVectorXd frame = changes.row(f);
        for (Eigen::Index c = 0; c < frame.size(); ++c) {
          const bool loose = electrodes[static_cast<std::size_t>(c)] & bad;
          if (loose && random.uniform() < 0.5) frame[c] = -reference[c];
        }
        found += look(frame).dead == bad;
      }
      EXPECT_GE(found, least[count]) << count << " at " << snr << " dB";
    }
  }
}

// Of a loose contact the channels that read are good, and their reciprocal channels mend the
// others.
TEST_F(FrontOfFrames, ReplacesOnlyWhatALooseContactLoses) {
  static const ValidationFile validation(1000);
  const FrameCheck check(validation.input(), 0);
  const auto electrodes = electrode_sets_of_channels(Sensor{});
  const Eigen::VectorXd reference = uniform_reference({});
  RandomStream random(5, 0, 0, Purpose::scene);
  const Frames changes = fresh_changes(20);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const ElectrodeSet bad = random_electrodes(4, random);
    Eigen::RowVectorXd frame = changes.row(f);
    std::vector<bool> lost(208, false);
    for (Eigen::Index c = 0; c < frame.size(); ++c) {
      const auto channel = static_cast<std::size_t>(c);
      lost[channel] = (electrodes[channel] & bad) != 0 && random.uniform() < 0.5;
      if (lost[channel]) frame[c] = -reference[c];
    }
    const FrameCheck::Verdict verdict = check.judge(frame.data());
    EXPECT_TRUE(verdict.torn);
    EXPECT_EQ(verdict.lost(), ElectrodeSet{0});
    check.impute(frame.data(), verdict);
    for (const auto& [a, b] : reciprocal_pairs(Sensor{})) {
      const bool lost_a = lost[static_cast<std::size_t>(a)];
      const bool lost_b = lost[static_cast<std::size_t>(b)];
      const double mended_a = lost_b ? frame[a] : changes(f, b);
      EXPECT_EQ(frame[a], lost_a ? mended_a : changes(f, a));
      if (!lost_b) {
        EXPECT_EQ(frame[b], changes(f, b));
      }
      if (lost_a && lost_b) {
        EXPECT_NE(frame[a], -reference[a]);
      }
    }
  }
}

TEST_F(FrontOfFrames, DetectsHalfDeadElectrodes) {
  const Frames changes = fresh_changes(400);
  for (const double share : {0.3, 0.5, 0.6}) {
    int found = 0;
    for (int e = 0; e < 16; ++e) {
      Eigen::RowVectorXd frame = blank(static_cast<std::uint64_t>(e));
      read_share(frame, e, share);
      const FrameState state = look(frame);
      EXPECT_EQ(state.half_dead, only(e)) << share;
      EXPECT_NEAR(state.lost, 1 - share, 0.1);
      for (Eigen::Index f = e; f < changes.rows(); f += 16) {
        frame = changes.row(f);
        read_share(frame, e, share);
        const ElectrodeSet half = look(frame).half_dead;
        found += half == only(e);
        EXPECT_TRUE(half == 0 || half == only(e)) << "another one is named";
      }
    }
    // Contacts beside the electrode may hide it.
    EXPECT_GE(found, share < 0.6 ? 380 : 320) << share;
  }
}

TEST_F(FrontOfFrames, NamesUpToFourHalfDeadElectrodes) {
  constexpr int least[] = {0, 190, 185, 165, 150};
  RandomStream random(4, 0, 0, Purpose::scene);
  for (const double snr : {50.0, 35.0}) {
    const Frames changes = fresh_changes(200, snr);
    for (int count = 1; count <= 4; ++count) {
      int found = 0;
      for (Eigen::Index f = 0; f < changes.rows(); ++f) {
        const ElectrodeSet bad = electrodes_apart(count, random);
        Eigen::RowVectorXd frame = changes.row(f);
        for_dead_channels(frame, bad, [&](double& change, double reference) {
          change = 0.5 * (change + reference) - reference;
        });
        found += look(frame).half_dead == bad;
      }
      EXPECT_GE(found, least[count]) << count << " at " << snr << " dB";
    }
  }
}

// A good conductor that shorts an electrode's neighbourhood lowers many of its voltages, too.
TEST_F(FrontOfFrames, TakesNoGoodConductorForAHalfDeadElectrode) {
  const nlohmann::json scenes = {{"contacts", {1, 3}}, {"conductivity_ratio", {3, 30}}};
  const nlohmann::json spec = {{"count", 1000}, {"seed", 11},       {"grid", "auto"},
                               {"snr_db", 50},  {"scenes", scenes}, {"snr_basis", "absolute"}};
  const TemporaryFolder folder;
  generate_dataset(dataset_spec_from_json(JsonObject(spec, "test", ""), {}, "test"),
                   folder / "test.h5");
  const DatasetFile set(folder / "test.h5");
  const Frames changes = set.voltages(0, 1000).rowwise() - set.reference_voltages().transpose();
  int named = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) named += look(changes.row(f)).half_dead != 0;
  EXPECT_LE(named, 10);
}

TEST_F(FrontOfFrames, SeesChannelsAtTheEndOfTheirRange) {
  const Eigen::RowVectorXd reference = uniform_reference({}).transpose();
  const double end = 1.25 * reference.cwiseAbs().maxCoeff();
  const Eigen::RowVectorXd clipped = (1.6 * reference).cwiseMin(end).cwiseMax(-end);
  EXPECT_TRUE(look(clipped - reference).saturated);
  EXPECT_FALSE(look(0.6 * reference + blank(1)).saturated);
}

TEST_F(FrontOfFrames, MeasuresTheNoiseOfAFrame) {
  const Eigen::RowVectorXd reference = uniform_reference({}).transpose();
  for (const double snr : {60.0, 45.0, 35.0}) {
    const Frames changes = fresh_changes(100, snr);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const double size = (changes.row(f) + reference).norm() / std::sqrt(208.0);
      // 104 differences scatter by 7 %.
      EXPECT_NEAR(20 * std::log10(size / look(changes.row(f)).noise), snr, 2.5) << f;
    }
  }
}

TEST_F(FrontOfFrames, RecoversAmplitudesWithinTheirDeviations) {
  const Eigen::RowVectorXd reference = uniform_reference({}).transpose();
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(16);
  moved[5] = 0.02;
  const Eigen::RowVectorXd displaced =
      BorderModel(Sensor{}, moved).reference_voltages().transpose() - reference;
  const Frames changes = fresh_changes(300);
  double deviation = 0;
  double level = 0;
  double displacement = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const double b = f % 2 ? 0.08 : -0.08;
    const FrameState state = look((changes.row(f) + reference) / (1 + b) - reference + displaced);
    level += std::pow((state.amplitudes[0] - b) / state.deviations[0], 2);
    displacement += std::pow((state.amplitudes[3 + 5] - 0.02) / state.deviations[3 + 5], 2);
    EXPECT_LT(state.deviations[0], 0.1) << "less is known than before";
    deviation += state.deviations[0];
  }
  EXPECT_LT(deviation / 300, 0.05);
  EXPECT_LT(std::sqrt(level / 300), 1.5);
  EXPECT_GT(std::sqrt(level / 300), 0.3);
  EXPECT_LT(std::sqrt(displacement / 300), 1.5);
}

TEST_F(FrontOfFrames, TakesLevelAndGradientOutOfABlankFrame) {
  DatasetSpec spec = random_contacts(40, {}, 1);
  spec.faults.background_gradient = 0.1;
  spec.faults.background_change = -0.06;
  const SceneModel model(Sensor{}, GridSheet{24});
  const Frames changes = generate_block(spec, model, 0, 40).voltages.rowwise() -
                         model.reference_voltages().transpose();
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const FrameState state = look(changes.row(f));
    EXPECT_NEAR(state.amplitudes[0], -0.06, 0.012);
    // The gradient is one of 0.1 over the half diagonal.
    EXPECT_NEAR(std::sqrt(2.0) * state.amplitudes.segment(1, 2).norm(), 0.1, 0.03);
    Eigen::RowVectorXd rest = changes.row(f);
    front().remove_nuisances(state, rest.data());
    EXPECT_LT(rest.norm(), 0.25 * changes.row(f).norm());
  }
}

TEST(FrontWithoutAFit, DetectsWhatReadsZero) {
  const Front front{Sensor{}};
  Frames changes = fresh_changes(1);
  EXPECT_EQ(front.look(changes.data()).dead, ElectrodeSet{0});
  read_zero(changes.row(0), only(3));
  const FrameState state = front.look(changes.data());
  EXPECT_EQ(state.dead, only(3));
  EXPECT_EQ(state.amplitudes.size(), 0);
}

TEST(FrontOfATank, RaisesNoAlarmOnMeasuredFrames) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  const Sensor tank = read_sensor(project / "sensors/tank.json");
  const TemporaryFolder folder;
  // Contacts like the cup that is moved through the tank, as experiments/tank.json has them.
  const nlohmann::json scenes = {{"contacts", 1},         {"shapes", {"disc"}},
                                 {"radius_mm", {8, 30}},  {"conductivity_ratio", {0.02, 0.6}},
                                 {"blank_fraction", 0.1}, {"placement", "inside"}};
  const nlohmann::json spec = {{"count", 400}, {"seed", 2},        {"grid", "auto"},
                               {"snr_db", 57}, {"scenes", scenes}, {"snr_basis", "absolute"}};
  generate_dataset(dataset_spec_from_json(JsonObject(spec, "test", ""), tank, "validation"),
                   folder / "validation.h5");
  const DatasetFile set(folder / "validation.h5");
  FitInput input;
  input.sensor = tank;
  input.validation = &set;
  const Front front(tank, FrameCheck(input, 0), {.level = 0.1, .gradient = 0.1});
  const Hdf5File file = Hdf5File::open(project / "experiments/data/tank_adjacent.h5");
  const Eigen::RowVectorXd reference = file.read_vector("/reference_voltages").transpose();
  const Frames frames = file.read_rows("/voltages", 0, 255);
  int alarms = 0;
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    const Eigen::RowVectorXd change = frames.row(f) - reference;
    const FrameState state = front.look(change.data());
    alarms += state.dead != 0 || state.saturated;
  }
  EXPECT_EQ(alarms, 0);
}

// Half of the presses are the validation set, the others are looked at.
TEST(FrontOfASkin, RaisesNoAlarmOnMeasuredPresses) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  const Sensor skin = read_sensor(project / "sensors/skin_opposite.json");
  const TemporaryFolder folder;
  const auto file_of = [&](const char* name, int first) {
    const nlohmann::json spec = {{"file", "experiments/data/skin_presses.h5"},
                                 {"rows", {first, first + 200}},
                                 {"contact", {{"radius_mm", 12}, {"conductivity_ratio", 0.4}}}};
    const std::filesystem::path file = folder / (std::string(name) + ".h5");
    generate_dataset(dataset_spec_from_json(JsonObject(spec, "test", ""), skin, name, project),
                     file);
    return DatasetFile(file);
  };
  const DatasetFile set = file_of("validation", 0);
  FitInput input;
  input.sensor = skin;
  input.validation = &set;
  const Front front(skin, FrameCheck(input, 0));
  const DatasetFile others = file_of("others", 200);
  const Frames changes =
      others.voltages(0, 200).rowwise() - others.reference_voltages().transpose();
  int alarms = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const FrameState state = front.look(changes.row(f).data());
    alarms += state.dead != 0 || state.saturated;
  }
  EXPECT_EQ(alarms, 0);
}

}  // namespace
}  // namespace ertbench
