#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What frames without contact tell of a sensor.
struct Calibration {
  static constexpr int schema = 1;

  Sensor sensor;              ///< as it was given
  int frames = 0;             ///< that were looked at
  Eigen::VectorXd reference;  ///< [channels] V: their mean
  /// [channels] V: standard deviation about the mean. Whatever moves slowly is in it, as it is in
  /// changes from a reference that was taken once.
  Eigen::VectorXd noise;
  /// [channels] V: the part of it that differs from frame to frame, of successive differences over
  /// the root of two.
  Eigen::VectorXd white_noise;
  /// 20 log10 of the size of the reference voltages, or of the change that a contact makes, over
  /// the size of the noise, dB.
  double snr_absolute = 0;
  double snr_white = 0;       ///< absolute, with the white part alone
  double snr_difference = 0;  ///< of the contact below
  /// A disc in the middle of the sheet: radius in parts of the largest disc's that fits, and its
  /// conductivity over the background's.
  static constexpr double contact_radius = 0.2;
  static constexpr double contact_ratio = 0.6;
  /// By which part the frames' level has moved along a straight line from the first to the last.
  double drift_level = 0;
  /// The size of what each channel has moved along its own line, over that of the reference.
  double drift = 0;
  std::vector<int> dead_electrodes;  ///< counted from 0: read nearly zero, or float
  /// |a - b| over |(a + b)/2| of the mean's reciprocal channels a, b; 0 of sensors without.
  double reciprocity_error = 0;
  double level = 1;       ///< of the reference over the model's, by which the background follows
  double background = 0;  ///< S/m that fits: the sensor's over the level
  double misfit = 0;      ///< of the reference from the model at that level, relative
};

/// `frames` [N, channels] V, 10 at least, in the sensor's order. Throws std::invalid_argument for
/// fewer.
Calibration calibrate(const Sensor& sensor, const Frames& frames);

/// What a calibration's file says besides.
nlohmann::json to_json(const Calibration& calibration);
/// Throws InputError with the place in `file`.
Calibration read_calibration(const std::filesystem::path& file);
/// Throws InputError where the calibration is of another sensor, its background aside.
void require_calibration_of(const Calibration& calibration, const Sensor& sensor,
                            const std::filesystem::path& file);

/// The scenes on which solvers choose what is "auto" and the check of frames finds its limits where
/// nobody gave a set: none to three random contacts on the continuous sheet of the sensor, with the
/// calibration's background and, frame by frame, white noise of its level (absolute basis).
DatasetSpec calibrated_spec(const Calibration& calibration, const Sensor& sensor,
                            const std::string& name);

/// Writes that set as `file`, and puts noise that differs from channel to channel as the
/// calibration's does in the place of the white noise: independent, Gaussian, by channel.
void write_calibrated_set(const Calibration& calibration, const Sensor& sensor,
                          const std::filesystem::path& file, int threads);

}  // namespace ertbench
