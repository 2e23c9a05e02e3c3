#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/arrays.h"
#include "core/random.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// White Gaussian noise of a set strength: SNR(dB) = 20 log10(|signal| / |noise|), exactly, frame
/// by frame. The signal is the frame itself (`absolute`, EIDORS's add_noise) or its change from the
/// reference voltages (`difference`).
enum class SnrBasis { absolute, difference };

struct Noise {
  std::optional<double> snr_db;  ///< without a value: no noise
  SnrBasis basis = SnrBasis::absolute;
  /// Noise by channel: each channel's deviation is exp(spread u) times the others', u standard
  /// normal and drawn for each frame. The SNR of the frame stays.
  double spread = 0;
};

/// Adds noise to one frame [channels] in place. `reference` [channels]. With the difference basis a
/// frame that equals the reference stays as it is: its signal is zero, and so is its noise.
void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame);

/// The 2-norm of the noise on a frame with these clean voltages, V. Without noise, that of 80 dB
/// (absolute), as a scale to compare model errors with.
double noise_norm(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
                  const Eigen::Ref<const Eigen::VectorXd>& frame);

const char* name_of(SnrBasis basis);

class JsonObject;

enum class DeadReading { zero, floating, half, intermittent };
enum class DisplacementReference { retaken, stale };

/// Faults between the sheet and the frame, all off by default. The size of a fault is set, its
/// direction is random: the same random stream gives the same electrodes, amplifiers and directions
/// for all sizes, so that frames of two levels are paired.
///
/// Faults of the electronics change only the measured frame; faults of the sheet also change the
/// clean voltages.
struct Faults {
  // Electronics.
  /// Number of electrodes without contact; those of n - 1 are among those of n.
  int dead_electrodes = 0;
  /// Reading of channels that drive or measure with a dead electrode: 0 V, white noise of the
  /// frame's root mean square, half the voltage, or (a loose contact) 0 V in every second channel
  /// at random.
  DeadReading dead_reading = DeadReading::zero;
  /// Each measuring pair's amplifier has gain 1 + gain_error u, u uniform in [-1, 1].
  double gain_error = 0;
  /// Each measuring pair adds offset u times the reference's root mean square.
  double offset = 0;
  /// Pick-up from the mains, of the reference's root mean square: a sine in the order of the
  /// channels, of random phase and of a random frequency up to half a channel's, as an alias has.
  double hum = 0;
  /// Share of the channel before that is left in a channel, when the multiplexer has not settled.
  /// The reference has it too, so that only the change does.
  double settling = 0;
  /// Resolution of the converter, which reads frame and reference; 0 for none, else 2 to 24.
  int adc_bits = 0;
  // A battery in place of a current source; the reference was taken `reference_age_s` earlier.
  double battery_sag = 0;         ///< loss of the drive current, fraction per hour
  double battery_noise = 0;       ///< relative rms noise of the drive current between frames
  bool current_measured = false;  ///< the frame is scaled by its measured current

  // Sheet.
  /// Each electrode sits uniformly in [-d, d] along the border from its place, domain units.
  double electrode_displacement = 0;
  /// Whether the reference was measured on the displaced electrodes, of the other width, and on the
  /// mottled film, too.
  DisplacementReference displacement_reference = DisplacementReference::retaken;
  /// Width of the electrodes, domain units, where the sensor has them as points or otherwise wide.
  double electrode_width = 0;
  /// Each contact impedance of electrodes with a width is (1 + u d) times that at the reference, u
  /// uniform in [-1, 1]; a sensor of another model gets impedances of a fifth of the sheet's
  /// resistance.
  double impedance_drift = 0;
  /// The conductivity of the whole sheet, contacts included, is 1 + b times that at the reference.
  double background_change = 0;
  /// Relative change of that conductivity per minute since the reference was taken.
  double background_drift = 0;
  /// The conductivity at (x, y) is 1 + g (x cos t + y sin t) / r times that of the even
  /// sheet, t random and r the sheet's radius (sqrt(2) for the square). The true image stays that
  /// of the contacts alone. On the continuous sheet its effect is that on the empty one, to first
  /// order.
  double background_gradient = 0;
  /// Relative standard deviation of a film that is not even, correlated over a quarter of the
  /// sheet's radius.
  double background_mottle = 0;

  /// Time between the reference and the frame, or the first moment of a sequence.
  double reference_age_s = 0;

  bool any() const { return of_electronics() || of_sheet() || of_battery() || of_time(); }
  bool of_battery() const { return battery_sag != 0 || battery_noise > 0; }
  bool of_time() const { return background_drift != 0 || reference_age_s > 0; }
  bool of_electronics() const {
    return dead_electrodes > 0 || gain_error > 0 || offset > 0 || hum > 0 || settling > 0 ||
           adc_bits > 0;
  }
  bool of_electrodes() const {
    return electrode_displacement > 0 || electrode_width > 0 || impedance_drift > 0;
  }
  bool of_sheet() const {
    return of_electrodes() || background_change != 0 || background_gradient > 0 ||
           background_mottle > 0;
  }
};

/// Applies the faults of the electronics to one frame [channels] V in place: gain, offset, hum,
/// dead electrodes, settling, converter, in this order, after any noise. `reference` [channels] V
/// is that of the faultless electronics. Draws the same numbers from `random` for all sizes, none
/// if all faults are off. The frame may have any origin, and a training set may use a new stream
/// each epoch.
void apply_faults(const Faults& faults, const Sensor& sensor,
                  const Eigen::Ref<const Eigen::VectorXd>& reference, RandomStream& random,
                  Eigen::Ref<Eigen::VectorXd> frame);

/// The factor by which a battery's current changes the voltages of a frame, `since_reference_s`
/// after the reference was taken. `random` is of Purpose::battery.
double battery_factor(const Faults& faults, double since_reference_s, RandomStream& random);

/// The factor by which the drift of the background changes the sheet's conductivity.
double drift_factor(const Faults& faults, double since_reference_s);

/// The recorded reference [channels] V: through the converter, if any, and without other faults.
Eigen::VectorXd recorded_reference(const Faults& faults, const Eigen::VectorXd& reference);

/// Displacement of each electrode, [electrodes] domain units, clockwise along the border. `random`
/// is of Purpose::displacement.
Eigen::VectorXd displacements(const Faults& faults, const Sensor& sensor, RandomStream& random);

/// The sensor whose electrodes have the width of the faults and contact impedances.
Sensor with_faulty_electrodes(const Faults& faults, const Sensor& sensor);
/// Factors [electrodes] of the contact impedances. `random` as for `displacements`, and after them.
Eigen::VectorXd impedance_factors(const Faults& faults, const Sensor& sensor, RandomStream& random);

/// The gradient of the background, relative per domain unit. `random` is of Purpose::gradient.
Eigen::Vector2d gradient_of(const Faults& faults, const Sheet& sheet, RandomStream& random);
/// Factors [pixels] by which the gradient of the background changes the conductivity of the pixels.
/// `random` is of Purpose::gradient.
Eigen::VectorXd gradient_factors(const Faults& faults, const Sheet& sheet, const PixelGrid& pixels,
                                 RandomStream& random);

/// Factors [pixels] of the mottled film. `random` is of Purpose::gradient.
Eigen::VectorXd mottle_factors(const Faults& faults, const Sheet& sheet, const PixelGrid& pixels,
                               RandomStream& random);

/// Reads an object with the members' names as keys, every key optional. Voltages come from `model`:
/// the continuous sheet knows electrodes at any place but no mottle, a grid the reverse.
Faults faults_from_json(JsonObject object, const Sensor& sensor, const SheetModel& model);
/// Only the keys of faults that are on.
nlohmann::json to_json(const Faults& faults);
nlohmann::ordered_json faults_schema();

}  // namespace ertbench
