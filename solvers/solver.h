#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// A linear map of frames to images, kept as `left` or as the product `left right`: a matrix of low
/// rank has fewer numbers in its two factors, and what a frame costs is reading them once.
template <typename Scalar>
struct ImageMap {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  Matrix left;   ///< [pixels, inputs], or [pixels, rank]
  Matrix right;  ///< empty, or [rank, inputs]

  bool factored() const { return right.size() > 0; }
  Eigen::Index inputs() const { return factored() ? right.cols() : left.cols(); }
  Eigen::Index pixels() const { return left.rows(); }
  /// Numbers that one frame reads.
  Eigen::Index size() const { return left.size() + right.size(); }

  template <typename Other>
  ImageMap<Other> cast() const {
    return {left.template cast<Other>(), right.template cast<Other>()};
  }
};

/// The product as it is cheaper: its factors, or multiplied out.
inline ImageMap<double> smaller_map(Eigen::MatrixXd left, Eigen::MatrixXd right) {
  if (left.size() + right.size() < left.rows() * right.cols()) {
    return {std::move(left), std::move(right)};
  }
  return {left * right, {}};
}

class DatasetFile;

enum class FrameStatus : std::uint8_t {
  ok = 0,
  not_converged = 1,  ///< an image, but not the one that was asked for (iteration limit)
  undefined = 2,      ///< no usable image; the pixels may be anything, also NaN
  suspect = 3,        ///< an image, but the frame is not one to trust: `reasons` says why
};

/// What speaks against a frame, as a set: bits of FrameReport::reasons.
enum FrameReason : std::uint8_t {
  dead_electrode = 1,  ///< an electrode without contact: its channels read zero, or float
  noise = 2,           ///< above what the solver was fitted for
  out_of_range = 4,    ///< voltages unlike those of any contacts that it was fitted for
  unexplained = 8,     ///< no contacts of its model explain it: said by the solver itself
};

/// A set of electrodes, bit e for electrode e; a sensor has at most 64.
using ElectrodeSet = std::uint64_t;

/// What is said of one frame: by the solver `status`, `iterations`, `gap` and of the reasons
/// `unexplained`, by the check of frames (solvers/check), which the registry puts around every
/// solver, the rest.
struct FrameReport {
  FrameStatus status = FrameStatus::ok;
  std::uint8_t reasons = 0;  ///< of FrameReason; also of a frame that is ok but had channels masked
  int iterations = 0;        ///< 0 for a solver that does not iterate
  double gap = 0;            ///< relative duality gap where the solver has one, else 0
  /// The dead electrodes of the frame. Known before the solver is called where it asks for them
  /// (MaskedChannels::detect).
  ElectrodeSet dead = 0;
  /// Relative change of the whole sheet's conductivity, as from water around it, that the solver
  /// found beside what its image shows; 0 where it looks for none.
  double level = 0;
};

/// Which channels a solver leaves out of account: those that use one of these electrodes.
struct MaskedChannels {
  ElectrodeSet electrodes = 0;  ///< in every frame
  bool detect = false;          ///< in each frame also those of its FrameReport::dead
};

/// One contact that a solver found in a frame.
struct FoundContact {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< centre, domain units
  /// Integral of |change of the conductivity| over the contact, S/m times squared domain units.
  double strength = 0;
  double peak = 0;  ///< largest |change of the conductivity|, S/m
  double area = 0;  ///< squared domain units
  /// Standard deviations of x and y of the place and of the strength, in their units; 0 where the
  /// solver knows none.
  Eigen::Vector2d place_deviation = Eigen::Vector2d::Zero();
  double strength_deviation = 0;
};

/// What a solver that knows contacts, not pixels alone, has besides its images.
class ContactFinder {
 public:
  virtual ~ContactFinder() = default;

  /// The contacts of each frame, the strongest first. `changes` as Solver::reconstruct has it;
  /// `contacts` [frames], empty when it is called. Const and thread-safe.
  virtual void find_contacts(FramesView changes,
                             std::span<std::vector<FoundContact>> contacts) const = 0;
};

/// Frames of one sequence in their order, of which a solver may use the last ones for the next: a
/// contact is seldom far from where it was. Serves one thread.
class FrameStream {
 public:
  virtual ~FrameStream() = default;

  /// The next frames, one or many; as Solver::reconstruct but for what the frames before say.
  virtual void reconstruct(FramesView changes, ImagesView images,
                           std::span<FrameReport> reports) = 0;
  /// The contacts of the last frame, the strongest first, where the solver knows contacts itself:
  /// the very ones that its image was made from. Null where it does not.
  virtual const std::vector<FoundContact>* contacts() const { return nullptr; }
};

/// What a solver may learn from. Classical solvers use the sensor and, for parameters given as
/// "auto", the validation set; learned ones the training set as well. Never a test set.
struct FitInput {
  Sensor sensor;
  const DatasetFile* training = nullptr;    ///< may be null
  const DatasetFile* validation = nullptr;  ///< may be null where no parameter is "auto"
  std::filesystem::path work_folder;        ///< for checkpoints and logs; exists
  int threads = 1;                          ///< upper limit
  /// Where set, called now and then by a long fit, from the calling thread, with what is done.
  std::function<void(std::uint64_t done, std::uint64_t total, const std::string& text)> progress;
};

/// How a fit went, where the solver it left can be used and yet there is something to say.
struct FitReport {
  std::string status = "ok";  ///< or a word or two: "diverged", "discriminator collapsed"
  std::string message;        ///< what happened, where the status is not "ok"
  double earlier_s = 0;       ///< spent by interrupted fits that this one went on from
  /// What is left of the check of frames where that could not be fitted; the wrapper's
  /// (solvers/check).
  std::string frame_check = {};
};

/// A reconstruction method: voltages in, image of the conductivity change out.
///
/// Life of a solver: made from its JSON by the registry (which checks every parameter), `fit` once
/// or `load` from a file that `save` wrote, then `reconstruct` any number of times. Bad input and
/// bad configuration throw InputError; a numerical failure is a FrameReport.
///
/// The registry puts a CheckedSolver around every solver, which has the duties that are the same
/// for all. A solver need not look whether it is fitted, whether frames, images and reports fit
/// together, whether frames and images are finite, whether a frame is one to trust, and whether a
/// file is of its type and its sensor.
///
/// A complete solver, back projection with the rows of the Jacobian:
///
///     class BackProjection final : public Solver {
///      public:
///       explicit BackProjection(JsonObject parameters)
///           : gain_(parameters.number_or("gain", 1.0, Range::positive())) { parameters.finish(); }
///       nlohmann::json parameters() const override { return {{"gain", gain_}}; }
///       void fit(const FitInput& input) override {
///         jacobian_ = uniform_jacobian(input.sensor);
///       }
///       void reconstruct(FramesView changes, ImagesView images,
///                        std::span<FrameReport>) const override {
///         images.noalias() = gain_ * changes * jacobian_;
///       }
///       ...
///     };
class Solver {
 public:
  virtual ~Solver() = default;

  /// The parameters in use, with whatever was "auto" replaced by what `fit` chose.
  virtual nlohmann::json parameters() const = 0;

  /// Throws InputError where the parameters do not suit this sensor; called before any work begins,
  /// and before `fit`.
  virtual void check(const Sensor&) const {}
  /// Whether `fit` needs the training set, and the validation set with it.
  virtual bool needs_training() const { return false; }

  /// Does everything that depends only on the sensor and the data. Throws InputError where a
  /// parameter is "auto" and the set it is chosen on is missing.
  virtual void fit(const FitInput& input) = 0;

  /// How `fit` went; kept by `save`.
  virtual FitReport fit_report() const { return {}; }

  /// Reconstructs all frames, one or many. Const and thread-safe.
  /// `changes` [frames, channels]: V, measured voltages less the reference voltages.
  /// `images` [frames, pixels]: S/m, change from the background, written in place.
  /// `reports` [frames], default-constructed by the caller. A solver writes the status where it is
  /// not ok, and what else it has to say.
  virtual void reconstruct(FramesView changes, ImagesView images,
                           std::span<FrameReport> reports) const = 0;
  /// The most frames that `reconstruct` is to be given at a time, few enough that what it computes
  /// for them stays in the cache; 0: all of them.
  virtual Eigen::Index block_frames() const { return 0; }
  /// Channels that `reconstruct` leaves out of account; the check of frames does likewise. Asked
  /// after `fit` and `load`.
  virtual MaskedChannels masked_channels() const { return {}; }

  /// Where frames leave this process: a solver that moves the same bytes to a process of its own
  /// and back and does nothing else, which the harness times beside this one. Null where they stay.
  /// Asked after `fit` and `load`; may outlive this solver.
  virtual std::unique_ptr<Solver> transport() const { return nullptr; }

  /// Where the solver knows contacts itself: whoever wants contacts takes these in place of those
  /// that are read out of its images. Null where it does not; lives as long as the solver.
  virtual const ContactFinder* contact_finder() const { return nullptr; }

  /// A new sequence, for solvers that use the frames before. Null where every frame stands alone;
  /// the registry's wrapper then gives a stream that reconstructs frame by frame, so that whoever
  /// got the solver from the registry always has one. Lives no longer than the solver.
  virtual std::unique_ptr<FrameStream> open_stream() const { return nullptr; }

  /// Writes what `fit` computed to one file, in any format; parameters that say how the solver is
  /// applied (ParameterRole::inference) have no part in it. The caller renames it into place.
  virtual void save(const std::filesystem::path& file) const = 0;
  /// Makes this solver what it was when it was saved. Throws InputError where the file is not one
  /// of this solver's, or for another sensor.
  virtual void load(const std::filesystem::path& file, const Sensor& sensor) = 0;
};

}  // namespace ertbench
