#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Electrodes, counted from 0, nearly all (four fifths) of whose channels are bad; `is_bad` is
/// asked for each channel.
std::vector<int> electrodes_with_bad_channels(const Sensor& sensor,
                                              const std::function<bool(Eigen::Index)>& is_bad);

/// Those whose channels are under a tenth of `expected`
/// [channels], in absolute values.
std::vector<int> electrodes_reading_zero(const Sensor& sensor, const Eigen::VectorXd& reference,
                                         const Eigen::VectorXd& expected);

/// The changes of voltages that contacts can make: the leading left singular vectors, those above a
/// hundredth of the first, of the changes by small discs all over the sheet. A dozen or two of
/// directions out of all channels, so that frames whose channels stand in another order hardly fit.
class ContactSpan {
 public:
  explicit ContactSpan(const Sensor& sensor);

  Eigen::Index directions() const { return basis_.cols(); }
  /// The part of the squares of `changes` [frames, channels] that lies in the span, 0 ... 1.
  double share(const Frames& changes) const;

 private:
  Eigen::MatrixXd basis_;  ///< [channels, directions], orthonormal
};

/// What the reference voltages are worth, held against the model of the sensor.
struct ReferenceVerdict {
  enum class State {
    sound,        ///< what the model expects, or as near as measured ones come
    mendable,     ///< not so, but `from` and `factor` make them so
    beyond_help,  ///< like the model's in no order that is known
  };

  State state = State::sound;
  /// Distance from the model's voltages at the best level, over the size of the voltages: as they
  /// came, and mended.
  double misfit = 0;
  double mended_misfit = 0;
  /// Over the model's, as they came. Voltages go with the current over the conductivity.
  double level = 1;
  bool is_level_alone = false;  ///< what is wrong: neither sign, unit nor order
  /// Of the frames' changes, the part that contacts can make, as they came and mended; 0 where no
  /// frame changes enough to tell.
  double explained = 0;
  double mended_explained = 0;
  std::vector<std::string> causes;  ///< likely ones of what is wrong, each with what mends it
  /// Channel c of a mended frame is factor[c] times channel from[c] of one as it came.
  std::vector<int> from;
  Eigen::VectorXd factor;
  /// What could be otherwise and would show in nothing that was looked at, in words.
  std::vector<std::string> unseen;
  std::vector<std::string> notes;  ///< what is odd and yet no reason to stop

  /// In lines: the fit, causes, what cannot be seen.
  std::string text() const;
};

/// Holds the reference voltages [channels] V, in what is taken to be the sensor's order, against
/// the continuous sheet's (BorderModel), and tries what goes wrong between instrument and program:
/// level and unit, sign, amplitudes without sign, electrodes that are counted from another one or
/// the other way round, drive and measurement exchanged, another order of the channels. `changes`
/// [frames, channels] V, frames less the reference, may be empty; where some change by more than
/// two per cent of the reference voltages, they tell apart what the reference alone cannot.
///
/// Another reading is preferred where it halves the misfit, at least. Measured references differ
/// from a model with point electrodes by ten per cent, so that up to fifteen are sound; over thirty
/// and without a reading that fits, they are beyond help. A level within a quarter of the model's
/// is sound. Electrodes that read zero are left out of account and named.
ReferenceVerdict check_reference(const Sensor& sensor, const Eigen::VectorXd& reference,
                                 const Frames& changes);

}  // namespace ertbench
