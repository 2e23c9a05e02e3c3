#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/linear/masked_inverse.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// How a fitted matrix is applied to frames. The fitted file is the same for all of them.
struct LinearInference {
  bool single_precision = false;  ///< "inference_precision": "float64" | "float32"
  /// "inference_averaging": whether the two channels of a reciprocal pair are added before the
  /// product, which halves the matrix and changes nothing but rounding.
  bool averaging = true;

  /// For the solver's registration.
  static std::vector<ParameterInfo> registered();
  static LinearInference from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
};

class Hdf5File;

/// A solver whose image is a fixed matrix times the frame. By reciprocity the matrix has equal
/// columns for the two channels of a pair, so it is kept once a pair, [pixels, channels / 2], and
/// multiplies the pairs' sums: half the memory to stream, with nothing lost. A matrix of low rank
/// is kept as its two factors where that is less still.
///
/// One frame is one or two matrix-vector products and allocates nothing; a batch is as many
/// matrix-matrix products. The two round differently (relative 1e-14; 1e-6 in single precision).
///
/// Where channels are masked from the start, their columns are zero. Where dead electrodes are
/// detected, the frames that have some are imaged a second time, by a MaskedInverse.
class LinearSolver : public Solver {
 public:
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const final;
  /// The images of so many frames stay in the second-level cache.
  Eigen::Index block_frames() const final { return 256; }
  MaskedChannels masked_channels() const final { return mask_; }
  void check(const Sensor& sensor) const override { mask_.check(sensor); }

 protected:
  /// `inference` is how frames are imaged, whatever file the fit may come from.
  explicit LinearSolver(const LinearInference& inference) : inference_(inference) {}

  void set_sensor(const Sensor& sensor);
  void set_mask(const ChannelMask& mask) { mask_ = mask; }

  /// J' at the uniform background [pairs, pixels], and the pairs of it that are not masked.
  Eigen::MatrixXd whole_jacobian() const;
  std::vector<Eigen::Index> kept_pairs() const { return pairs_without(sensor_, mask_.electrodes); }

  /// `inverse` [pixels, kept pairs] maps d' (see Reciprocity) to the image. Until `finish` it is
  /// applied in double precision, whatever the inference is to be.
  void set_inverse(const Eigen::MatrixXd& inverse);
  /// The same as a product, `left` [pixels, rank] times `right` [rank, kept pairs].
  void set_inverse(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right);
  /// Brings the matrix into the form that the inference wants; the end of fit.
  void finish();
  /// What images frames with dead electrodes, where they are to be detected.
  virtual std::unique_ptr<const MaskedInverse> masked_inverse() const = 0;

  const Sensor& sensor() const { return sensor_; }
  const Reciprocity& reciprocity() const { return reciprocity_; }
  const LinearInference& inference() const { return inference_; }
  const ChannelMask& mask() const { return mask_; }

  void save_matrix(Hdf5File& file) const;
  void load_matrix(const Hdf5File& file, const Sensor& sensor);

 private:
  template <typename Scalar>
  void apply(const ImageMap<Scalar>& map, FramesView changes, ImagesView images) const;
  /// The inputs of one frame: the sums of its pairs, or all its channels.
  template <typename Scalar>
  void gather(const double* frame, Eigen::Index inputs, Scalar* out) const;

  /// Images the frames with dead electrodes once more, without these.
  void mask_dead(FramesView changes, ImagesView images, std::span<const FrameReport> reports) const;

  Sensor sensor_;
  Reciprocity reciprocity_;
  ChannelMask mask_;
  std::unique_ptr<const MaskedInverse> masked_;
  LinearInference inference_;
  ImageMap<double> map_;                  ///< acts on d_a + d_b
  std::optional<ImageMap<double>> full_;  ///< acts on all channels
  std::optional<ImageMap<float>> single_;
};

}  // namespace ertbench
