#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

/// Electrodes, counted from 0, at least four fifths of whose channels are bad.
std::vector<int> electrodes_with_bad_channels(const Sensor& sensor,
                                              const std::function<bool(Eigen::Index)>& is_bad);

/// Electrodes whose channels are below a tenth of `expected` [channels] in absolute value.
std::vector<int> electrodes_reading_zero(const Sensor& sensor, const Eigen::VectorXd& reference,
                                         const Eigen::VectorXd& expected);

/// The reference with `expected` [channels] V in the place of channels of electrodes that read
/// zero, unless half of them do. Frames then change there, which is how solvers find such
/// electrodes.
Eigen::VectorXd filled_reference(const Sensor& sensor, const Eigen::VectorXd& reference,
                                 const Eigen::VectorXd& expected);

/// Channels, counted from 0, with the same value in all frames, of which three are needed; none if
/// that is true of more than half of the channels.
std::vector<int> channels_that_never_change(const Frames& frames);
/// "channels 3 (drive 0, measurement 5), 17 (drive 1, measurement 7)", four at most.
std::string text_of_channels(const Sensor& sensor, const std::vector<int>& channels);

/// The space of voltage changes that contacts can cause: the left singular vectors, with values
/// above three thousandths of the largest, of the changes by small discs all over the sheet. Its
/// dimensions are a third of the channels or fewer, so frames with channels in a wrong order hardly
/// fit; several strong contacts do, to two per cent of the squared norm.
class ContactSpan {
 public:
  explicit ContactSpan(const Sensor& sensor);

  Eigen::Index directions() const { return basis_.cols(); }
  /// Share of the squared norm of `changes` [frames, channels] inside the span, 0 ... 1.
  double share(const Frames& changes) const;
  /// The part of a change [channels] outside the span.
  Eigen::RowVectorXd rest(const Eigen::Ref<const Eigen::RowVectorXd>& change) const;

 private:
  Eigen::MatrixXd basis_;  ///< [channels, directions], orthonormal
};

/// Result of comparing reference voltages with the model of the sensor.
struct ReferenceVerdict {
  enum class State {
    sound,        ///< they fit the model as well as measured ones do
    mendable,     ///< they fit after `from` and `factor` are applied
    beyond_help,  ///< they fit in no known order
  };

  State state = State::sound;
  /// Relative distance from the model's voltages at the best level, before and after mending.
  double misfit = 0;
  double mended_misfit = 0;
  /// Level relative to the model's; voltages scale with the current over the conductivity.
  double level = 1;
  bool unexplained = false;     ///< contacts explain much less of the changes than noise leaves
  bool is_level_alone = false;  ///< only the level is wrong: neither sign, unit nor order
  /// Share of the frames' changes that contacts can cause, before and after mending; 0 if no frame
  /// changes enough.
  double explained = 0;
  double mended_explained = 0;
  std::vector<int> dead;            ///< electrodes whose channels read zero
  std::vector<std::string> causes;  ///< likely causes, each with its remedy
  /// Channel c of a mended frame is factor[c] times channel from[c] of the original.
  std::vector<int> from;
  Eigen::VectorXd factor;
  /// Mends every channel by the gain that takes `reference` to `expected`, both [channels] V:
  /// changes relative to the reference, times the model's voltages.
  void normalise(const Eigen::VectorXd& reference, const Eigen::VectorXd& expected);
  std::vector<std::string> unseen;  ///< errors that these data cannot reveal, in words
  std::vector<std::string> notes;   ///< oddities that are no reason to stop

  /// The fit, the causes and what the data cannot reveal, in lines.
  std::string text() const;
};

/// Compares reference voltages [channels] V with the continuous sheet's (BorderModel) and tries the
/// usual errors between instrument and program: level and unit, sign, amplitudes without sign,
/// electrodes counted from another one or in the opposite direction, drive and measurement
/// exchanged, another order of the channels. `changes` [frames, channels] V, frames minus the
/// reference, may be empty; those above two per cent of the reference voltages help to decide.
/// Where no reading fits but contacts explain the changes relative to the reference, the gains of
/// the channels are steady, and that is mended.
///
/// Another reading is preferred if it at least halves the misfit. Measured references differ from a
/// model with point electrodes by ten per cent, so up to fifteen are sound; above thirty, and
/// without a reading that fits, they are beyond help. A level within a quarter of the model's is
/// sound. Electrodes that read zero are left out and named. So are dead channels, which never
/// change, and changes of which contacts explain much less than their noise leaves.
ReferenceVerdict check_reference(const Sensor& sensor, const Eigen::VectorXd& reference,
                                 const Frames& changes);

/// Whether to mend the frames: they are mendable and `fix` is asked for. Throws InputError, which
/// begins with `source`, if they are neither sound nor mended nor imaged all the same by `force`.
bool settle(const ReferenceVerdict& verdict, const std::string& source, bool fix, bool force);

/// Symmetries of the sheet, about its centre and without the identity, that no voltages show: a
/// contact and its image give the same voltages, as with opposite drive and opposite measurement.
/// Compares the sensitivity of the channels at places and at their images.
std::vector<Eigen::Matrix2d> twin_symmetries(const Sensor& sensor);

/// Puts behind each contact its images at which it would give the same voltages.
void add_twins(const Sensor& sensor, const std::vector<Eigen::Matrix2d>& twins,
               std::vector<FoundContact>& contacts);

/// "(x, y) and (-x, -y) give the same voltages ..."; empty without a symmetry.
std::string text_of_twins(const std::vector<Eigen::Matrix2d>& symmetries);

}  // namespace ertbench
