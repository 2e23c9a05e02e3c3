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

/// A sensor's noise, drift, level and dead electrodes, measured on frames without contact.
struct Calibration {
  static constexpr int schema = 1;

  Sensor sensor;              ///< as given
  Sensor declared;            ///< the same, with channels that had no number in the recording
  int frames = 0;             ///< number of frames used
  Eigen::VectorXd reference;  ///< [channels] V, median of the frames
  /// [channels] V, standard deviation about the mean. It includes slow changes, as changes from a
  /// reference taken once do.
  Eigen::VectorXd noise;
  /// [channels] V, white part of the noise: rms of successive differences over the root of two.
  Eigen::VectorXd white_noise;
  /// SNR in dB, 20 log10 of 2-norms: of the reference voltages over the noise.
  double snr_absolute = 0;
  double snr_white = 0;       ///< of the reference voltages over the white noise
  double snr_difference = 0;  ///< of the change by the contact below over the noise
  /// A disc in the middle of the sheet: radius relative to the largest disc that fits, and its
  /// conductivity relative to the background.
  static constexpr double contact_radius = 0.2;
  static constexpr double contact_ratio = 0.6;
  /// Relative change of the frames' level along a straight line from the first to the last.
  double drift_level = 0;
  /// Norm of the channels' changes along their lines over the norm of the reference.
  double drift = 0;
  std::vector<int> dead_electrodes;  ///< counted from 0: they read nearly zero, or float
  /// |a - b| over |(a + b)/2| of the mean's reciprocal channels a, b; 0 if the sensor has none.
  double reciprocity_error = 0;
  double level = 1;       ///< the reference over the model's
  double background = 0;  ///< fitted background, S/m: the sensor's over the level
  double misfit = 0;      ///< relative distance of the reference from the model at that level
};

/// `frames` [N, channels] V, 10 at least, in the sensor's order. Throws std::invalid_argument for
/// fewer.
Calibration calibrate(const Sensor& sensor, const Frames& frames);

/// What is wrong with frames [N, channels] V that should be without contact.
struct QuietCheck {
  std::vector<Eigen::Index> unlike;  ///< frames that FrameBounds flags, or far from the median
  std::string refused;  ///< why nothing can be calibrated on them as they are; empty if it can
};

/// Compares frames with their median. A frame is unlike the others if it is flagged (FrameBounds)
/// or five times as far from the median as the middle frame. Frames of which half repeat the one
/// before know no noise.
QuietCheck check_quiet(const Sensor& sensor, const Frames& frames);
/// What the user should know of a calibration: drift, channels that never change.
std::vector<std::string> warnings_of(const Calibration& calibration);

nlohmann::json to_json(const Calibration& calibration);
/// Throws InputError with the place in `file`.
Calibration read_calibration(const std::filesystem::path& file);
/// Throws InputError if the calibration is of another sensor; the background may differ.
void require_calibration_of(const Calibration& calibration, const Sensor& sensor,
                            const std::filesystem::path& file);

/// The calibration for the channels of `sensor`, NaN for those that it has not. Throws InputError
/// if the sensors differ otherwise.
Calibration on_channels_of(const Calibration& calibration, const Sensor& sensor,
                           const std::filesystem::path& file);

/// The default scenes on which solvers choose "auto" parameters and the frame check its limits:
/// none to three random contacts on the sensor's continuous sheet, with the calibration's
/// background and white noise of its level (absolute basis).
DatasetSpec calibrated_spec(const Calibration& calibration, const Sensor& sensor,
                            const std::string& name);

/// Writes that set as `file`, with the white noise replaced by independent Gaussian noise of each
/// channel's calibrated standard deviation.
void write_calibrated_set(const Calibration& calibration, const Sensor& sensor,
                          const std::filesystem::path& file, int threads);

/// Gives an entry of `contacts` what it would take from a validation set: the noise of the frames
/// without contact, over the root mean square of their mean, at the model's level, and the prior as
/// it is. A measured reference [channels] V lies away from the model's: this is the model error,
/// and level, gradient and electrodes are unknowns, too. Other entries stay as they are.
void complete_contacts(nlohmann::json& entry, const Sensor& sensor,
                       const Eigen::VectorXd& reference, double relative_noise);

}  // namespace ertbench
