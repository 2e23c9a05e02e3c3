#pragma once

#include <torch/nn/modules/linear.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "core/arrays.h"
#include "models/inference/inference_plan.h"
#include "models/networks/tensor_file.h"
#include "models/training/objective.h"
#include "models/training/standardisation.h"
#include "models/training/trainer.h"
#include "solvers/front/front.h"
#include "solvers/layered_solver.h"
#include "solvers/solver.h"

namespace ertbench {

/// The regularised inverse of the sensitivity, (J^T J + lambda^2 R^T R)^-1 J^T [pixels, channels]
/// in S/m per V, of the solver one-step-gn with the NOSER prior; lambda is chosen on the validation
/// set.
RowMajorMatrix sensitivity_inverse(const FitInput& input);

/// Sets a dense layer [channels + told -> pixels] to one-step Gauss-Newton between the units of a
/// network, from standardised frames to y.
void set_sensitivity_inverse(torch::nn::Linear& layer, const FitInput& input,
                             const Standardisation& standardisation);

/// EIT-NN's blur of the target (Park et al. 2021): S = (J^T J + lambda^2 L)^-1 J^T J [pixels,
/// pixels] with the prior L of one-step-gn "laplace"; entries below a quarter of their column's
/// largest are set to zero. Without `lambda` it is chosen on the validation set.
RowMajorMatrix spatial_blur(const FitInput& input, std::optional<double> lambda);

/// A solver that is a trained network. Derived classes provide the network, its initialisation and
/// the objective of its training; all else is here.
///
/// `fit` needs a training and a validation set. The fitted file (solver_file.h) holds the weights
/// by name in `/network` (tensor_file.h), the standardisation [channels] in `/mean` and `/scale`,
/// and the report of the training as JSON text in the attribute `training`. `load` refuses weights
/// of another network than the parameters describe, by name.
class LearnedSolver : public Solver, public LayeredSolver, public ToldSolver {
 public:
  /// The settings and, once fitted, the report of the training under "training".
  nlohmann::json parameters() const final;
  void check(const Sensor& sensor) const override = 0;
  bool needs_training() const final { return true; }
  void fit(const FitInput& input) final;
  FitReport fit_report() const final;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const final;
  std::optional<LayerList> layers() const final;
  bool is_told() const final { return told_; }
  Frames usual_frames(const FitInput& input) const final;
  MaskedChannels masked_channels() const final { return {.detect = is_told()}; }
  void save(const std::filesystem::path& file) const final;
  void load(const std::filesystem::path& file, const Sensor& sensor) final;
  /// Few enough that the feature maps of convolutions stay in the cache.
  Eigen::Index block_frames() const override { return 64; }

 protected:
  /// `training`: the defaults of its settings.
  LearnedSolver(std::string type, const TrainingSettings& training)
      : type_(std::move(type)), standard_training_(training) {}

  /// The sensor of the fit; the default sensor before `fit` or `load`.
  const Sensor& sensor() const { return sensor_; }
  const Standardisation& standardisation() const { return standardisation_; }
  const Network& network() const { return *network_; }  ///< only after `fit` or `load`

  /// The settings of the network and its objective.
  virtual void visit(Fields& fields) = 0;
  /// Reads all settings but the inference's.
  void read(JsonObject object);
  /// The setting "front", of networks that can be told what is wrong with a frame.
  void visit_front(Fields& fields);
  /// Inputs of the network behind the channels of a frame.
  int told(const Sensor& sensor) const { return told_ ? Front::told(sensor) : 0; }
  virtual std::shared_ptr<Network> make_network(const Sensor& sensor) const = 0;
  /// Reads "inference_precision". Only for networks of dense layers: libtorch has no transposed
  /// convolution in bfloat16.
  void read_inference(JsonObject& object);
  /// Overwrites the random weights of the network's constructor, and the standardisation if the
  /// weights belong to another.
  virtual void initialise(Network&, const FitInput&, Standardisation&) const {}
  virtual std::unique_ptr<Objective> make_objective(const FitInput& input) const = 0;
  /// True if matrix products over many frames are faster than one frame after the other, because
  /// reading the weights takes most of the time.
  virtual bool batches_share_weights() const { return false; }

  TrainingSettings training_;

 private:
  nlohmann::json settings() const;
  /// The standardised frame and what is told of it, [channels + told], into `inputs`.
  void enter(const FramesView& changes, Eigen::Index frame, std::span<const FrameReport> reports,
             float* inputs) const;
  void freeze(const Sensor& sensor, std::shared_ptr<Network> network);

  std::string type_;
  TrainingSettings standard_training_;
  bool told_ = false;
  bool bfloat16_inference_ = false;
  Sensor sensor_;
  Standardisation standardisation_;
  std::shared_ptr<Network> network_;     ///< null before fit or load
  std::optional<Front> front_;           ///< of a network that is told
  std::unique_ptr<InferencePlan> plan_;  ///< for single frames
  std::optional<FrozenGraph> graph_;     ///< for batches, if batches_share_weights, or no plan
  nlohmann::json result_;                ///< report of the training, with the hardware it ran on
};

}  // namespace ertbench
