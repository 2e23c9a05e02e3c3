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

/// A linear map from frames to images, stored as `left` or as the product `left right`. A matrix of
/// low rank has fewer numbers in its two factors, and reading them dominates the time of a frame.
template <typename Scalar>
struct ImageMap {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  Matrix left;   ///< [pixels, inputs], or [pixels, rank]
  Matrix right;  ///< empty, or [rank, inputs]

  bool factored() const { return right.size() > 0; }
  Eigen::Index inputs() const { return factored() ? right.cols() : left.cols(); }
  Eigen::Index pixels() const { return left.rows(); }
  /// Stored numbers, all of which one frame reads.
  Eigen::Index size() const { return left.size() + right.size(); }

  template <typename Other>
  ImageMap<Other> cast() const {
    return {left.template cast<Other>(), right.template cast<Other>()};
  }
};

/// The map left * right, stored as two factors if they have fewer numbers than their product.
inline ImageMap<double> smaller_map(Eigen::MatrixXd left, Eigen::MatrixXd right) {
  if (left.size() + right.size() < left.rows() * right.cols()) {
    return {std::move(left), std::move(right)};
  }
  return {left * right, {}};
}

class DatasetFile;

enum class FrameStatus : std::uint8_t {
  ok = 0,
  not_converged = 1,  ///< has an image, but the iteration limit was reached
  undefined = 2,      ///< no usable image; the pixels may have any value, also NaN
  suspect = 3,        ///< flagged: has an image, but should not be trusted; see `reasons`
};

/// Reasons why a frame is flagged, as bits of FrameReport::reasons.
enum FrameReason : std::uint8_t {
  dead_electrode = 1,  ///< an electrode without contact: its channels read zero, or float
  noise = 2,           ///< more noise than in the frames that the solver was fitted on
  out_of_range = 4,    ///< voltages outside the range of the frames it was fitted on
  unexplained = 8,     ///< no contacts of the solver's model explain the frame; set by the solver
};

/// A set of electrodes, bit e for electrode e; a sensor has at most 64.
using ElectrodeSet = std::uint64_t;

/// Report on one frame. The solver sets `status`, `iterations`, `gap`, `level` and the reason
/// `unexplained`; the frame check (solvers/check), which wraps every solver, sets the rest.
struct FrameReport {
  FrameStatus status = FrameStatus::ok;
  std::uint8_t reasons = 0;  ///< set of FrameReason; a frame with masked channels has some, too
  int iterations = 0;        ///< 0 for a solver that does not iterate
  double gap = 0;            ///< relative duality gap; 0 for a solver without one
  /// Dead electrodes of the frame. Set before the solver is called if it asks for them
  /// (MaskedChannels::detect).
  ElectrodeSet dead = 0;
  /// Relative change of the whole sheet's conductivity, such as from water around it, that the
  /// solver estimated beside its image; 0 if it estimates none.
  double level = 0;
};

/// Channels that a solver ignores: those that use one of these electrodes.
struct MaskedChannels {
  ElectrodeSet electrodes = 0;  ///< in every frame
  bool detect = false;          ///< additionally those of FrameReport::dead in each frame
};

/// One contact detected in a frame.
struct FoundContact {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< centre, domain units
  /// Integral of |change of the conductivity| over the contact, S/m times squared domain units.
  double strength = 0;
  double peak = 0;  ///< largest |change of the conductivity|, S/m
  double area = 0;  ///< squared domain units
  /// Standard deviations of x and y of the position and of the strength, in their units; 0 if the
  /// solver gives none.
  Eigen::Vector2d place_deviation = Eigen::Vector2d::Zero();
  double strength_deviation = 0;
};

/// Interface of solvers that detect contacts themselves, not only pixels.
class ContactFinder {
 public:
  virtual ~ContactFinder() = default;

  /// Contacts of each frame, the strongest first. `changes` as for Solver::reconstruct; `contacts`
  /// [frames] comes empty. Const and thread-safe.
  virtual void find_contacts(FramesView changes,
                             std::span<std::vector<FoundContact>> contacts) const = 0;
};

/// A sequence of frames in temporal order, in which a solver may start from the frames before.
/// Used by one thread.
class FrameStream {
 public:
  virtual ~FrameStream() = default;

  /// Reconstructs the next frames, one or many; parameters as for Solver::reconstruct.
  virtual void reconstruct(FramesView changes, ImagesView images,
                           std::span<FrameReport> reports) = 0;
  /// Contacts of the last frame, the strongest first, from which its image was made. Null if the
  /// solver detects no contacts itself.
  virtual const std::vector<FoundContact>* contacts() const { return nullptr; }
};

/// Input of a fit. Classical solvers use the sensor and, for parameters given as "auto", the
/// validation set; learned solvers also use the training set. No solver sees a test set.
struct FitInput {
  Sensor sensor;
  const DatasetFile* training = nullptr;    ///< may be null
  const DatasetFile* validation = nullptr;  ///< may be null if no parameter is "auto"
  std::filesystem::path work_folder;        ///< for checkpoints and logs; exists
  int threads = 1;                          ///< upper limit
  /// If set, called now and then by a long fit, from the calling thread.
  std::function<void(std::uint64_t done, std::uint64_t total, const std::string& text)> progress;
};

/// Report on a fit that left a usable solver.
struct FitReport {
  std::string status = "ok";  ///< or a word or two: "diverged", "discriminator collapsed"
  std::string message;        ///< explains a status other than "ok"
  double earlier_s = 0;       ///< time of interrupted fits that this one continued
  /// Why the frame check (solvers/check) could not be fitted, and what it still detects.
  std::string frame_check = {};
};

/// A reconstruction method: voltages in, image of the conductivity change out.
///
/// Life of a solver: made from its JSON by the registry (which checks every parameter), `fit` once
/// or `load` from a file that `save` wrote, then `reconstruct` any number of times. Bad input and
/// bad configuration throw InputError; a numerical failure is a FrameReport.
///
/// The registry wraps every solver in a CheckedSolver, which has the duties common to all. A solver
/// may therefore assume that it is fitted, that frames, images and reports have matching shapes,
/// that frames are finite, and that a file to load is of its type and sensor.
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

  /// The parameters in use, with the values that `fit` chose in place of "auto".
  virtual nlohmann::json parameters() const = 0;

  /// Throws InputError if the parameters do not suit this sensor; called before `fit`.
  virtual void check(const Sensor&) const {}
  /// True if `fit` needs the training set and the validation set.
  virtual bool needs_training() const { return false; }

  /// Computes everything that depends only on the sensor and the data. Throws InputError if a
  /// parameter is "auto" and the set it is chosen on is missing.
  virtual void fit(const FitInput& input) = 0;

  /// Report on `fit`; `save` keeps it.
  virtual FitReport fit_report() const { return {}; }

  /// Reconstructs all frames, one or many. Const and thread-safe.
  /// `changes` [frames, channels]: V, measured voltages less the reference voltages.
  /// `images` [frames, pixels]: S/m, change from the background, written in place.
  /// `reports` [frames], default-constructed by the caller; the solver changes what differs.
  virtual void reconstruct(FramesView changes, ImagesView images,
                           std::span<FrameReport> reports) const = 0;
  /// Largest number of frames to pass to `reconstruct` at a time, such that its intermediate
  /// results stay in the cache; 0: any number.
  virtual Eigen::Index block_frames() const { return 0; }
  /// Channels that `reconstruct` and the frame check ignore. Valid after `fit` or `load`.
  virtual MaskedChannels masked_channels() const { return {}; }

  /// For solvers whose frames leave this process: a solver that only moves the same bytes to
  /// another process and back, so that the transport can be timed. Else null. Valid after `fit` or
  /// `load`; may outlive this solver.
  virtual std::unique_ptr<Solver> transport() const { return nullptr; }

  /// The solver's own detection of contacts, used in place of contacts detected in its images. Null
  /// if it has none; lives as long as the solver.
  virtual const ContactFinder* contact_finder() const { return nullptr; }

  /// Starts a sequence, for solvers that use the frames before. Null if frames are independent; the
  /// registry's wrapper then returns a stream that reconstructs frame by frame, so that solvers
  /// from the registry always have one. Must not outlive the solver.
  virtual std::unique_ptr<FrameStream> open_stream() const { return nullptr; }

  /// Writes the result of `fit` to one file in any format, without the parameters of the inference
  /// (ParameterRole::inference). The caller renames the file into place.
  virtual void save(const std::filesystem::path& file) const = 0;
  /// Restores the solver that was saved. Throws InputError for a file of another type of solver or
  /// another sensor.
  virtual void load(const std::filesystem::path& file, const Sensor& sensor) = 0;
};

}  // namespace ertbench
