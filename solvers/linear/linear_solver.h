#pragma once

#include <Eigen/Core>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/layered_solver.h"
#include "solvers/linear/masked_inverse.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"

namespace ertbench {

/// How a fitted matrix is applied to frames; does not change the fitted file.
struct LinearInference {
  bool single_precision = false;  ///< "inference_precision": "float64" | "float32"
  /// "inference_averaging": adds the two channels of a reciprocal pair before the product, which
  /// halves the matrix and only changes rounding.
  bool averaging = true;

  /// The parameters, for the registration of solvers.
  static std::vector<ParameterInfo> registered();
  static LinearInference from_json(JsonObject& object);
  void add_to(nlohmann::json& parameters) const;
};

class Hdf5File;

/// Layers to the means of the reciprocal pairs. Throws InputError for a mask that is detected anew
/// in each frame.
LayerList pair_layers(const Reciprocity& reciprocity, const ChannelMask& mask);
/// A matrix that acts on sums of pairs (Reciprocity::sum) as one that acts on their means.
Eigen::MatrixXd on_means(Eigen::MatrixXd matrix, const Reciprocity& reciprocity);
/// Adds a dense layer to the last value.
void add_dense(LayerList& list, const Eigen::MatrixXf& matrix, const Eigen::VectorXf& bias);

/// A solver whose image is a fixed matrix times the frame. By reciprocity the two channels of a
/// pair have equal columns; the matrix is stored once per pair, [pixels, channels / 2], and
/// multiplies the sums of the pairs, which halves the memory traffic. A matrix of low rank is
/// stored as two factors if they are smaller.
///
/// A frame takes one or two matrix-vector products and no allocation; a batch takes as many
/// matrix-matrix products. The two round differently (relative 1e-14; 1e-6 in single precision).
///
/// Columns of channels that are masked in every frame are zero. Frames with detected dead
/// electrodes, or all where the image follows their noise, are imaged by a FrameInverse.
class LinearSolver : public Solver, public LayeredSolver {
 public:
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const final;
  /// As many frames as have images that stay in the second-level cache.
  Eigen::Index block_frames() const final { return 256; }
  MaskedChannels masked_channels() const final { return mask_; }
  void check(const Sensor& sensor) const override { mask_.check(sensor); }
  std::optional<LayerList> layers() const final;
  nlohmann::json parameters() const override;
  void save(const std::filesystem::path& file) const final;
  void load(const std::filesystem::path& file, const Sensor& sensor) final;

 protected:
  /// `inference` applies to fitted and to loaded matrices.
  LinearSolver(const char* type, const LinearInference& inference)
      : type_(type), inference_(inference) {}

  /// Reads the parameters of the fit and calls `finish` of the object.
  virtual void read(JsonObject parameters) = 0;
  virtual nlohmann::json fit_parameters() const = 0;
  /// The results of the fit, in a file that has its parameters; for a solver with more than the
  /// matrix.
  virtual void save_fit(Hdf5File& file) const { save_matrix(file); }
  virtual void load_fit(const Hdf5File& file, const Sensor& sensor) { load_matrix(file, sensor); }

  void set_sensor(const Sensor& sensor);
  void set_mask(const ChannelMask& mask) { mask_ = mask; }

  /// J' at the uniform background [pairs, pixels], and the indices of its pairs that are not
  /// masked.
  Eigen::MatrixXd whole_jacobian() const;
  std::vector<Eigen::Index> kept_pairs() const { return pairs_without(sensor_, mask_.electrodes); }

  /// `inverse` [pixels, kept pairs] maps d' (see Reciprocity) to the image. It is applied in double
  /// precision until `finish`.
  void set_inverse(const Eigen::MatrixXd& inverse);
  /// As above for the product of `left` [pixels, rank] and `right` [rank, kept pairs].
  void set_inverse(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right);
  /// Converts the matrix to the form of the inference; the last step of a fit.
  void finish();
  /// For frames with detected dead electrodes, or for all of them if images follow their noise.
  virtual std::unique_ptr<const FrameInverse> frame_inverse() const = 0;
  virtual bool follows_noise() const { return false; }

  const Sensor& sensor() const { return sensor_; }
  const Reciprocity& reciprocity() const { return reciprocity_; }
  const ChannelMask& mask() const { return mask_; }

  void save_matrix(Hdf5File& file) const;
  void load_matrix(const Hdf5File& file, const Sensor& sensor);

 private:
  template <typename Scalar>
  void apply(const ImageMap<Scalar>& map, FramesView changes, ImagesView images) const;
  /// Inputs of the map for one frame: the sums of its pairs, or all its channels.
  template <typename Scalar>
  void gather(const double* frame, Eigen::Index inputs, Scalar* out) const;

  void apply_matrix(FramesView changes, ImagesView images) const;

  const char* type_;
  Sensor sensor_;
  Reciprocity reciprocity_;
  ChannelMask mask_;
  std::unique_ptr<const FrameInverse> by_frame_;
  LinearInference inference_;
  ImageMap<double> map_;                  ///< acts on d_a + d_b
  std::optional<ImageMap<double>> full_;  ///< acts on all channels
  std::optional<ImageMap<float>> single_;
};

}  // namespace ertbench
