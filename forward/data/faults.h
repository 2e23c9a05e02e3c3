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
  std::optional<double> snr_db;  ///< none: no noise
  SnrBasis basis = SnrBasis::absolute;
};

/// Adds noise to one frame [channels] in place. `reference` [channels]. With the difference basis a
/// frame that equals the reference stays as it is: its signal is zero, and so is its noise.
void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame);

/// The 2-norm of the noise on a frame of these clean voltages, V. A set without noise has none to
/// compare with: there the noise of 80 dB (absolute) stands in.
double noise_norm(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
                  const Eigen::Ref<const Eigen::VectorXd>& frame);

const char* name_of(SnrBasis basis);

class JsonObject;

enum class DeadReading { zero, floating };
enum class DisplacementReference { retaken, stale };

/// What goes wrong between the sheet and the frame, all of it off by default. Every fault is random
/// in its direction and set in its size: the same random stream gives the same electrodes,
/// amplifiers and directions whatever the sizes, so that frames of two levels are paired.
///
/// Faults of the electronics change the measured frame alone; those of the sheet change its physics
/// and hence the clean voltages too.
struct Faults {
  // Of the electronics.
  /// Electrodes without contact; those of n - 1 are among those of n.
  int dead_electrodes = 0;
  /// What channels that drive or measure with a dead electrode show: 0 V, or white noise of the
  /// frame's root mean square.
  DeadReading dead_reading = DeadReading::zero;
  /// Each measuring pair's amplifier has gain 1 + gain_error u, u uniform in [-1, 1].
  double gain_error = 0;
  /// Each measuring pair adds offset u times the reference's root mean square.
  double offset = 0;
  /// Resolution of the converter, which reads frame and reference; 0 for none, else 2 to 24.
  int adc_bits = 0;
  // Of a battery in the place of a current source; the drawn-out reference was taken when it was
  // `reference_age_s` younger.
  double battery_sag = 0;         ///< loss of the drive current, as a fraction an hour
  double battery_noise = 0;       ///< of the drive current, relative, rms from frame to frame
  bool current_measured = false;  ///< and the frame scaled to the nominal current

  // Of the sheet.
  /// Each electrode sits uniformly in [-d, d] along the border from its place, domain units.
  double electrode_displacement = 0;
  /// Whether the reference was measured on the displaced electrodes too.
  DisplacementReference displacement_reference = DisplacementReference::retaken;
  /// The conductivity of the whole sheet, contacts included, is 1 + b times what it was when the
  /// reference was taken.
  double background_change = 0;
  /// The same, growing: the relative change a minute since the reference was taken.
  double background_drift = 0;
  /// The conductivity at (x, y) is 1 + g (x cos t + y sin t) / r times that of the even
  /// sheet, t random and r the sheet's radius (sqrt(2) for the square). The true image stays that
  /// of the contacts alone.
  double background_gradient = 0;

  /// Time between the reference and the frame, or the first moment of a sequence.
  double reference_age_s = 0;

  bool any() const { return of_electronics() || of_sheet() || of_battery() || of_time(); }
  bool of_battery() const { return battery_sag != 0 || battery_noise > 0; }
  bool of_time() const { return background_drift != 0 || reference_age_s > 0; }
  bool of_electronics() const {
    return dead_electrodes > 0 || gain_error > 0 || offset > 0 || adc_bits > 0;
  }
  bool of_sheet() const {
    return electrode_displacement > 0 || background_change != 0 || background_gradient > 0;
  }
};

/// Puts the faults of the electronics into one frame [channels] V in place: gain, offset, dead
/// electrodes, converter, in this order; noise belongs before them. `reference` [channels] V is the
/// nominal one, of the faultless electronics. Takes the same numbers from `random` whatever their
/// sizes, none where all are off. For a frame of any origin: a training set may draw a fresh stream
/// each epoch.
void apply_faults(const Faults& faults, const Sensor& sensor,
                  const Eigen::Ref<const Eigen::VectorXd>& reference, RandomStream& random,
                  Eigen::Ref<Eigen::VectorXd> frame);

/// The factor of one frame's voltages by a battery's current, `since_reference_s` after the
/// reference was taken. `random` is of Purpose::battery.
double battery_factor(const Faults& faults, double since_reference_s, RandomStream& random);

/// That of the sheet's conductivity by the drift of its background.
double drift_factor(const Faults& faults, double since_reference_s);

/// The reference as it was recorded, [channels] V: through the converter where there is one. It was
/// taken before all other faults came.
Eigen::VectorXd recorded_reference(const Faults& faults, const Eigen::VectorXd& reference);

/// How far each electrode sits from its place, [electrodes] domain units, clockwise along the
/// border. `random` is of Purpose::displacement.
Eigen::VectorXd displacements(const Faults& faults, const Sensor& sensor, RandomStream& random);

/// Factors [pixels] of the conductivity of a sheet's pixels, by the background's gradient.
/// `random` is of Purpose::gradient.
Eigen::VectorXd gradient_factors(const Faults& faults, const Sheet& sheet, const PixelGrid& pixels,
                                 RandomStream& random);

/// Reads an object with the members' names as keys, every key optional. Voltages come from `model`:
/// the continuous sheet knows electrodes at any place but no gradient, a grid the reverse.
Faults faults_from_json(JsonObject object, const Sensor& sensor, const SheetModel& model);
/// The keys that differ from a faultless frame; an object without keys where none does.
nlohmann::json to_json(const Faults& faults);
nlohmann::ordered_json faults_schema();

}  // namespace ertbench
