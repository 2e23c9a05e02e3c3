// Voltages that no contacts on a sheet can cause, and those that they can.

#include "frames/frame_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "forward/data/scene_distribution.h"
#include "solvers/channel_mask.h"
#include "tests/forward/disc_sheet.h"
#include "tests/frames/frames_testing.h"

namespace ertbench {
namespace {

/// Changes by up to four contacts of any strength, with noise of 30 dB of the reference's norm.
Frames strong_changes(const Sensor& sensor, int count) {
  const BorderModel model(sensor);
  const double inner = sensor.sheet->inner_radius();
  SceneDistribution scenes;
  scenes.contacts = {1, 4};
  scenes.conductivity_ratio = {0.001, 20};
  scenes.radius = {0.06 * inner, 0.4 * inner};
  const Eigen::Index channels = sensor.channels();
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, std::pow(10, -30.0 / 20) *
                                                model.reference_voltages().norm() /
                                                std::sqrt(static_cast<double>(channels)));
  Frames out(count, channels);
  for (int f = 0; f < count; ++f) {
    RandomStream stream(7, 1, static_cast<std::uint64_t>(f), Purpose::scene);
    out.row(f) = model.solve_at(scenes.draw(stream, *sensor.sheet), 0.7).change.transpose();
    for (double& v : out.row(f)) v += noise(random);
  }
  return out;
}

Eigen::RowVectorXd model_reference(const Sensor& sensor) {
  return BorderModel(sensor).reference_voltages().transpose();
}

TEST(FrameBounds, SoundFramesAreNotFlagged) {
  for (const Sensor& sensor : {Sensor{}, testing::disc_sensor()}) {
    const FrameBounds bounds(sensor);
    const Eigen::RowVectorXd reference = model_reference(sensor);
    const Frames changes = strong_changes(sensor, 200);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const FrameVerdict verdict = bounds.judge(changes.row(f), reference);
      EXPECT_EQ(verdict.faults, 0) << f << ": " << verdict.text();
    }
    EXPECT_EQ(bounds.judge(0 * reference, reference).faults, 0);
  }
}

TEST(FrameBounds, AnElectrodeThatReadsZeroIsFoundWhateverTheGain) {
  const Sensor sensor;
  const FrameBounds bounds(sensor);
  const std::vector<ElectrodeSet> electrodes = electrode_sets_of_channels(sensor);
  const Eigen::RowVectorXd reference = 1.2 * model_reference(sensor);
  const Frames changes = strong_changes(sensor, sensor.electrode_count);
  for (int e = 0; e < sensor.electrode_count; ++e) {
    Eigen::RowVectorXd change = 0.2 * changes.row(e);
    for (Eigen::Index c = 0; c < change.size(); ++c) {
      if (electrodes[static_cast<std::size_t>(c)] >> e & 1) change[c] = -reference[c];
    }
    const FrameVerdict verdict = bounds.judge(change, reference);
    EXPECT_EQ(verdict.electrode, e) << verdict.text();
    EXPECT_TRUE(verdict.faults & dead_electrode);
    FrameReport said;
    said.dead = ElectrodeSet{1} << e;
    EXPECT_EQ(bounds.judge(change, reference, said).faults, 0);
  }
}

TEST(FrameBounds, VoltagesRoundedAsCoarselyAsTheyChangeAreFlagged) {
  const Sensor sensor;
  const FrameBounds bounds(sensor);
  const Eigen::RowVectorXd reference = model_reference(sensor);
  const double errors = std::sqrt(static_cast<double>(reference.size()) / 12);
  const Frames changes = strong_changes(sensor, 20);
  for (const double share : {1e-4, 0.01}) {  // of the rounding errors in the reference
    const double step = share * reference.norm() / errors;
    const auto rounded = [&](const Eigen::RowVectorXd& v) -> Eigen::RowVectorXd {
      return step * (v / step).array().round();
    };
    for (const auto& strong : changes.rowwise()) {
      const Eigen::RowVectorXd change = 0.02 * reference.norm() / strong.norm() * strong;
      const FrameVerdict verdict = bounds.judge(rounded(reference + change) - reference, reference);
      EXPECT_EQ(verdict.step > 0, share > 0.001) << verdict.text();
      if (share > 0.001) {
        EXPECT_NEAR(verdict.step, step, 1e-6 * step);
        EXPECT_TRUE(verdict.faults & unexplained);
      }
    }
  }
}

TEST(FrameBounds, FramesOfAnotherUnitSignOrLevelAreFlaggedUnderAnyContacts) {
  const Sensor sensor;
  const FrameBounds bounds(sensor);
  const Eigen::RowVectorXd reference = model_reference(sensor);
  const Frames changes = strong_changes(sensor, 20);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const Eigen::RowVectorXd voltages = reference + changes.row(f);
    const auto faults = [&](const Eigen::RowVectorXd& frame) {
      return bounds.judge(frame - reference, reference).faults;
    };
    EXPECT_EQ(faults(1e3 * voltages), wrong_level) << f;
    EXPECT_EQ(faults(1e-3 * voltages), wrong_level) << f;
    EXPECT_EQ(faults(reference + voltages), wrong_level) << f;
    EXPECT_EQ(faults(-voltages), turned_sign) << f;
    EXPECT_EQ(faults(-1e3 * voltages), turned_sign | wrong_level) << f;
    EXPECT_EQ(faults(Eigen::RowVectorXd::Constant(208, 1000)) & wrong_level, wrong_level) << f;
    Eigen::RowVectorXd one = voltages;
    one[100] = 1000;
    EXPECT_EQ(faults(one), impossible_change) << f;
    EXPECT_NE(faults(Eigen::RowVectorXd::Constant(208, reference.mean())), 0);
  }
  EXPECT_NE(bounds.judge(999 * reference, reference).text().find("millivolts for volts"),
            std::string::npos);
}

TEST(FrameBounds, FramesThatAreAMultipleOrInAnotherOrderAreFlagged) {
  std::mt19937 random(11);
  for (const Sensor& sensor : {Sensor{}, testing::disc_sensor()}) {
    const FrameBounds bounds(sensor);
    const Eigen::RowVectorXd reference = model_reference(sensor);
    const RowMajorMatrix changes =
        testing::changes_by_discs(sensor, {{0.4, -0.3}, {0, 0.1}, {-0.5, 0.2}});
    for (const auto& change : changes.rowwise()) {
      for (const double gain : {0.5, 0.7, 1.3, 2.0}) {
        const Eigen::RowVectorXd voltages = gain * (reference + change);
        EXPECT_EQ(bounds.judge(voltages - reference, reference).faults, wrong_level) << gain;
        FrameReport said;  // the solver saw that the sheet has changed as a whole
        said.level = 1 / gain - 1;
        if (gain != 2 && gain != 0.5) {
          EXPECT_EQ(bounds.judge(voltages - reference, reference, said).faults & wrong_level, 0);
        }
      }
      Eigen::RowVectorXd stuck = change;
      Eigen::Index channel = 0;
      reference.cwiseAbs().maxCoeff(&channel);
      stuck[channel] -= reference[channel];
      const FrameVerdict verdict = bounds.judge(stuck, reference);
      EXPECT_EQ(verdict.channel, channel) << verdict.text();
      EXPECT_EQ(verdict.faults, unexplained);
      Eigen::RowVectorXd voltages = reference + change;
      std::shuffle(voltages.begin(), voltages.end(), random);
      EXPECT_NE(bounds.judge(voltages - reference, reference).faults, 0);
      Eigen::RowVectorXd other = change;
      std::shuffle(other.begin(), other.end(), random);
      EXPECT_EQ(bounds.judge(4 * other, reference).faults, unexplained);
    }
  }
}

TEST(FrameBounds, ChannelsOfDeadElectrodesDoNotCount) {
  const Sensor sensor;
  const FrameBounds bounds(sensor);
  const Eigen::RowVectorXd reference = model_reference(sensor);
  const auto drives = drive_pairs(sensor);
  const auto measured = measurement_pairs(sensor);
  const std::vector<Channel> channels = channels_of(sensor);
  Eigen::RowVectorXd change = Eigen::RowVectorXd::Zero(reference.size());
  FrameReport said;
  for (const int electrode : {0, 4, 8, 12}) {
    said.dead |= ElectrodeSet{1} << electrode;
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const auto& drive = drives[static_cast<std::size_t>(channels[c].drive)];
      const auto& pair = measured[static_cast<std::size_t>(channels[c].measurement)];
      for (const int e : {drive.first, drive.second, pair.first, pair.second}) {
        if (e == electrode) change[static_cast<Eigen::Index>(c)] = -reference[static_cast<int>(c)];
      }
    }
  }
  EXPECT_NE(bounds.judge(change, reference).faults, 0);
  EXPECT_EQ(bounds.judge(change, reference, said).faults, 0);
  said.dead = ~ElectrodeSet{0};
  EXPECT_NE(bounds.judge(-0.999 * reference, reference, said).faults, 0)
      << "all electrodes seem dead in a frame of a thousandth";
}

TEST(FrameBounds, EachReferenceIsHeldAgainstTheOthers) {
  const Sensor sensor;
  Frames references = model_reference(sensor).replicate(9, 1);
  references.row(7) *= 0;
  references.row(3) *= 3;
  references.row(4) *= 1.05;
  const std::vector<FrameVerdict> verdicts = FrameBounds(sensor).judge_references(references);
  for (std::size_t f = 0; f < verdicts.size(); ++f) {
    EXPECT_EQ(verdicts[f].faults != 0, f == 3 || f == 7) << f;
  }
}

TEST(FrameBounds, AVerdictMakesAFrameSuspectAndNoImageAnImage) {
  FrameVerdict verdict;
  verdict.faults = wrong_level;
  FrameReport sound, undefined;
  undefined.status = FrameStatus::undefined;
  report(verdict, sound);
  report(verdict, undefined);
  EXPECT_EQ(sound.status, FrameStatus::suspect);
  EXPECT_EQ(sound.reasons, wrong_level);
  EXPECT_EQ(undefined.status, FrameStatus::undefined);
}

}  // namespace
}  // namespace ertbench
