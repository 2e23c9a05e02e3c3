#include "bench/frames/calibration.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bench/frames/dead_electrodes.h"
#include "core/quantile.h"
#include "forward/border/border_model.h"

namespace ertbench {
namespace {

constexpr Eigen::Index least_frames = 10;
constexpr double floating_noise = 10;  ///< of a channel, over the middle channel's

double decibels(double signal, double noise) {
  // What no instrument reaches stands for frames that are all alike.
  constexpr double most = 300;
  return noise > 0 ? std::min(most, 20 * std::log10(signal / noise)) : most;
}

/// How far each channel moves from the first frame to the last along its straight line, [channels].
Eigen::RowVectorXd lines_of(const Frames& frames) {
  const Eigen::Index count = frames.rows();
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(count, -0.5, 0.5);
  return time.transpose() * frames / time.squaredNorm();
}

double change_of_a_contact(const Sensor& sensor, const BorderModel& model) {
  Contact disc;
  disc.centre = sensor.sheet->bounds().center();
  disc.half_size.setConstant(Calibration::contact_radius * sensor.sheet->inner_radius());
  disc.conductivity_ratio = Calibration::contact_ratio;
  return model.solve_at({{disc}}, 1).change.norm();
}

double reciprocity_error_of(const Sensor& sensor, const Eigen::VectorXd& reference) {
  double differences = 0;
  double means = 0;
  for (const auto& [a, b] : reciprocal_pairs(sensor)) {
    differences += std::pow(reference[a] - reference[b], 2);
    means += std::pow((reference[a] + reference[b]) / 2, 2);
  }
  return means > 0 ? std::sqrt(differences / means) : 0;
}

}  // namespace

Calibration calibrate(const Sensor& sensor, const Frames& frames) {
  const Eigen::Index count = frames.rows();
  if (count < least_frames || frames.cols() != sensor.channels()) {
    throw std::invalid_argument("calibrate: ten frames of the sensor's channels, at least");
  }
  Calibration out;
  out.sensor = sensor;
  out.frames = static_cast<int>(count);
  const Eigen::RowVectorXd mean = frames.colwise().mean();
  out.reference = mean.transpose();
  const Frames rest = frames.rowwise() - mean;
  const auto freedom = static_cast<double>(count - 1);
  out.noise = (rest.colwise().squaredNorm() / freedom).cwiseSqrt().transpose();
  const Frames steps = frames.bottomRows(count - 1) - frames.topRows(count - 1);
  out.white_noise = (steps.colwise().squaredNorm() / (2 * freedom)).cwiseSqrt().transpose();

  const Eigen::RowVectorXd lines = lines_of(frames);
  out.drift = mean.norm() > 0 ? lines.norm() / mean.norm() : 0;
  out.drift_level = mean.norm() > 0 ? lines.dot(mean) / mean.squaredNorm() : 0;
  out.reciprocity_error = reciprocity_error_of(sensor, out.reference);

  const BorderModel model(sensor);
  const Eigen::VectorXd& expected = model.reference_voltages();
  out.level = out.reference.dot(expected) / expected.squaredNorm();
  out.background = sensor.background / out.level;
  out.misfit = out.reference.norm() > 0
                   ? (out.reference - out.level * expected).norm() / out.reference.norm()
                   : 1;
  out.snr_absolute = decibels(out.reference.norm(), out.noise.norm());
  out.snr_white = decibels(out.reference.norm(), out.white_noise.norm());
  out.snr_difference =
      decibels(std::abs(out.level) * change_of_a_contact(sensor, model), out.noise.norm());

  std::vector<int> zero = electrodes_reading_zero(sensor, out.reference, out.level * expected);
  const double usual = median(std::vector<double>(out.noise.begin(), out.noise.end()));
  const std::vector<int> floating = electrodes_with_bad_channels(
      sensor, [&](Eigen::Index c) { return out.noise[c] > floating_noise * usual && usual > 0; });
  zero.insert(zero.end(), floating.begin(), floating.end());
  std::sort(zero.begin(), zero.end());
  zero.erase(std::unique(zero.begin(), zero.end()), zero.end());
  out.dead_electrodes = std::move(zero);
  return out;
}

}  // namespace ertbench
