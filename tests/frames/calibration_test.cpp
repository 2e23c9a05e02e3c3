// Calibration on simulated frames whose noise is known, and on frames of a water tank that a
// commercial instrument measured.

#include "frames/calibration.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/files.h"
#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/rasterise.h"
#include "frames/reference_check.h"
#include "tests/forward/disc_sheet.h"
#include "tests/frames/frames_testing.h"

namespace ertbench {
namespace {

constexpr int simulated = 400;

/// Noise whose standard deviation grows from channel to channel, from 1e-5 V to 3e-5 V.
Eigen::VectorXd known_noise(const Sensor& sensor) {
  return Eigen::VectorXd::LinSpaced(sensor.channels(), 1e-5, 3e-5);
}

Frames frames_without_contact(const Sensor& sensor, double level, double drift) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Eigen::VectorXd reference = BorderModel(sensor).reference_voltages();
  const Eigen::VectorXd noise = known_noise(sensor);
  Frames frames(simulated, sensor.channels());
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    const double moved = 1 + drift * (static_cast<double>(f) / (simulated - 1) - 0.5);
    for (Eigen::Index c = 0; c < frames.cols(); ++c) {
      frames(f, c) = level * moved * reference[c] + noise[c] * normal(random);
    }
  }
  return frames;
}

TEST(Calibration, FindsTheNoiseThatIsThere) {
  const Sensor sensor;
  const Calibration c = calibrate(sensor, frames_without_contact(sensor, 1.2, 0));
  const Eigen::VectorXd noise = known_noise(sensor);
  // A standard deviation from n frames is known to 1/sqrt(2 n), 3.5 %; five of that over 208.
  EXPECT_LT((c.noise.cwiseQuotient(noise).array() - 1).abs().maxCoeff(), 0.18);
  EXPECT_LT((c.white_noise.cwiseQuotient(noise).array() - 1).abs().maxCoeff(), 0.22);
  const Eigen::VectorXd reference = BorderModel(sensor).reference_voltages();
  const double snr = 20 * std::log10(1.2 * reference.norm() / noise.norm());
  EXPECT_NEAR(c.snr_absolute, snr, 0.1);
  EXPECT_NEAR(c.snr_white, snr, 0.1);
  // The same contact by finite elements on a fine grid.
  const ForwardModel model(sensor, 96);
  Eigen::VectorXd ratio(96 * 96);
  rasterise(testing::disc_at(0, 0, 0.2, 0.6), sensor.sheet->pixels(96), Rasterisation::area, ratio);
  const Images image = sensor.background * ratio.transpose();
  const double change = (model.solve(image).row(0).transpose() - model.reference_voltages()).norm();
  EXPECT_NEAR(c.snr_difference, 20 * std::log10(1.2 * change / noise.norm()), 0.1);
  EXPECT_NEAR(c.level, 1.2, 1e-4);
  EXPECT_NEAR(c.background, 0.05, 1e-5);
  EXPECT_LT(c.misfit, 1e-3);
  EXPECT_LT(c.reciprocity_error, 1e-3);
  EXPECT_LT(std::abs(c.drift_level), 1e-4);
  EXPECT_TRUE(c.dead_electrodes.empty());
}

// A contact impedance stays as it is where the sheet conducts better, so that the voltages' level
// alone does not tell the background.
TEST(Calibration, FindsTheBackgroundBehindContactImpedances) {
  Sensor declared;
  declared.electrode_model = ElectrodeModel::complete;
  declared.electrode_width = 0.15;
  declared.contact_impedance = 0.02;
  Sensor there = declared;
  there.background = 1;
  const Calibration c = calibrate(declared, frames_without_contact(there, 1, 0));
  EXPECT_NEAR(c.background, 1, 1e-3);
  EXPECT_LT(c.misfit, 1e-2);
  EXPECT_GT(std::abs(declared.background / c.level - 1), 0.02);
}

TEST(Calibration, TellsDriftFromNoise) {
  const Sensor sensor;
  const Calibration c = calibrate(sensor, frames_without_contact(sensor, 1, 0.02));
  EXPECT_NEAR(c.drift_level, 0.02, 1e-4);
  EXPECT_NEAR(c.drift, 0.02, 1e-3);
  const Eigen::VectorXd noise = known_noise(sensor);
  EXPECT_LT((c.white_noise.cwiseQuotient(noise).array() - 1).abs().maxCoeff(), 0.22);
  EXPECT_GT(c.noise.norm(), 2 * noise.norm());
  // A straight line of this length has a standard deviation of its length over sqrt(12).
  const double spread = 0.02 * BorderModel(sensor).reference_voltages().norm() / std::sqrt(12.0);
  EXPECT_NEAR(c.noise.norm(), std::hypot(spread, noise.norm()), 0.02 * spread);
}

TEST(Calibration, NamesDeadAndFloatingElectrodes) {
  const Sensor sensor;
  Frames frames = frames_without_contact(sensor, 1, 0);
  std::mt19937 random(4);
  std::normal_distribution<double> normal(0, 0.01);
  const std::vector<Channel> channels = channels_of(sensor);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto c = static_cast<Eigen::Index>(i);
    for (const int pair : {channels[i].drive, channels[i].measurement}) {
      if (pair == 2 || pair == 3) frames.col(c).setZero();  // electrode 3
      if (pair == 9 || pair == 10) {
        for (double& v : frames.col(c)) v += normal(random);  // electrode 10
      }
    }
  }
  EXPECT_EQ(calibrate(sensor, frames).dead_electrodes, (std::vector<int>{3, 10}));
}

TEST(Calibration, FramesUnlikeTheOthersAreNamed) {
  const Sensor sensor;
  const Frames quiet = frames_without_contact(sensor, 1, 0.18);
  EXPECT_EQ(check_quiet(sensor, quiet).refused, "") << "a drift is said, not refused";
  Frames frames = quiet;
  frames.row(17) *= 1000;
  frames.row(30) += testing::changes_by_discs(sensor, {{0.5, 0.5}}).row(0);
  const QuietCheck check = check_quiet(sensor, frames_without_contact(sensor, 1, 0));
  EXPECT_TRUE(check.unlike.empty()) << check.refused;
  EXPECT_EQ(check_quiet(sensor, frames).unlike, (std::vector<Eigen::Index>{17}))
      << "a touch is less than this drift";
  frames = frames_without_contact(sensor, 1, 0);
  frames.row(17) *= 1000;
  frames.row(30) += testing::changes_by_discs(sensor, {{0.5, 0.5}}).row(0);
  const QuietCheck two = check_quiet(sensor, frames);
  EXPECT_EQ(two.unlike, (std::vector<Eigen::Index>{17, 30}));
  EXPECT_NE(two.refused.find("17 (its level is"), std::string::npos) << two.refused;
  EXPECT_NE(check_quiet(sensor, frames.row(0).replicate(40, 1)).refused.find("repeat"),
            std::string::npos);

  EXPECT_NEAR(calibrate(sensor, frames).level, 1, 1e-4) << "the reference is a median";
  EXPECT_NE(warnings_of(calibrate(sensor, quiet)).at(0).find("drift by 18.0 %"), std::string::npos);
  frames = frames_without_contact(sensor, 1, 0);
  frames.col(5).setZero();
  EXPECT_NE(warnings_of(calibrate(sensor, frames)).at(0).find("channel 5 (drive 0, measurement 7)"),
            std::string::npos);
}

TEST(Calibration, FramesOfWhichHalfAreTouchedAreRefused) {
  const Sensor sensor;
  const BorderModel model(sensor);
  Frames frames = frames_without_contact(sensor, 1, 0).topRows(10).eval();
  EXPECT_TRUE(check_quiet(sensor, frames).refused.empty());
  for (int f = 0; f < 6; ++f) {
    const double angle = f;
    const Scene disc = testing::disc_at(0.4 * std::cos(angle), 0.4 * std::sin(angle), 0.25, 0.4);
    frames.row(4 + f) += model.solve_at(disc, 1).change.transpose();
  }
  EXPECT_NE(check_quiet(sensor, frames).refused.find("they are touched"), std::string::npos);
}

TEST(Calibration, IsReadAsItWasWritten) {
  const TemporaryFolder folder("calibration");
  const Sensor sensor;
  const Calibration c = calibrate(sensor, frames_without_contact(sensor, 1.1, 0.01));
  std::ofstream(folder / "c.json") << to_json(c).dump();
  const Calibration read = read_calibration(folder / "c.json");
  EXPECT_EQ(to_json(read), to_json(c));
  Sensor other = sensor;
  other.drive_current *= 2;
  EXPECT_THROW(require_calibration_of(read, other, "c.json"), InputError);
  Sensor wetter = sensor;
  wetter.background *= 2;
  EXPECT_NO_THROW(require_calibration_of(read, wetter, "c.json"));
}

TEST(Calibration, MakesScenesWithItsNoise) {
  const TemporaryFolder folder("calibrated");
  Sensor sensor;
  const Calibration c = calibrate(sensor, frames_without_contact(sensor, 1.2, 0));
  sensor.background = c.background;
  write_calibrated_set(c, sensor, folder / "set.h5", 2);
  const DatasetFile set(folder / "set.h5");
  EXPECT_EQ(set.sensor(), sensor);
  EXPECT_EQ(set.why_changed(), "");
  const Frames rest = set.voltages(0, set.size()) - set.clean_voltages(0, set.size());
  const Eigen::VectorXd noise =
      (rest.colwise().squaredNorm() / static_cast<double>(rest.rows())).cwiseSqrt().transpose();
  EXPECT_LT((noise.cwiseQuotient(c.noise).array() - 1).abs().maxCoeff(), 0.2);
}

/// The numbers that an analysis of the same recording with other programs came to: 57.6 dB,
/// reciprocity to 2.7 %, point electrodes on the homogeneous disc off by 10.8 %.
TEST(Calibration, OfAWaterTank) {
  Sensor sensor = testing::disc_sensor();
  sensor.drive_current = 0.005;
  const Hdf5File file = Hdf5File::open(ERTBENCH_TEST_DATA "/tank_frames.h5");
  const Frames frames = file.read_rows("/voltages", 0, 20);
  const Calibration c = calibrate(sensor, frames);
  EXPECT_NEAR(c.snr_absolute, 57.6, 0.05);
  EXPECT_NEAR(c.reciprocity_error, 0.027, 0.001);
  EXPECT_NEAR(c.misfit, 0.108, 0.005);
  EXPECT_GT(c.snr_white, c.snr_absolute + 3) << "it drifts";
  EXPECT_TRUE(c.dead_electrodes.empty());
  EXPECT_GT(c.level, 0);

  // Nothing is wrong but the conductivity of the water, which nobody knew.
  const Frames moved = file.read_rows("/voltages", 20, 5).rowwise() - c.reference.transpose();
  const ReferenceVerdict before = check_reference(sensor, c.reference, moved);
  EXPECT_TRUE(before.state == ReferenceVerdict::State::sound || before.is_level_alone)
      << before.text();
  sensor.background = c.background;
  const ReferenceVerdict verdict = check_reference(sensor, c.reference, moved);
  EXPECT_EQ(verdict.state, ReferenceVerdict::State::sound) << verdict.text();
  EXPECT_NEAR(verdict.level, 1, 1e-9);
  // Were the channels in another order, the cup's changes would not be a contact's.
  EXPECT_GT(verdict.explained, 0.8) << verdict.text();
}

}  // namespace
}  // namespace ertbench
