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
#include "solvers/solver.h"

namespace ertbench {

/// What the networks take from the physics.

/// The regularised inverse of the sensitivity, (J^T J + lambda^2 R^T R)^-1 J^T [pixels, channels]
/// in S/m per V, as the solver one-step-gn with the NOSER prior has it; lambda is chosen on the
/// validation set.
RowMajorMatrix sensitivity_inverse(const FitInput& input);

/// Makes of a dense layer [channels -> pixels] what one-step Gauss-Newton is, seen by a network:
/// standardised frames to y.
void set_sensitivity_inverse(torch::nn::Linear& layer, const FitInput& input,
                             const Standardisation& standardisation);

/// EIT-NN's blur of the target (Park et al. 2021): S = (J^T J + lambda^2 L)^-1 J^T J [pixels,
/// pixels], L the prior of one-step-gn "laplace", entries under a quarter of their column's largest
/// set to zero. `lambda`: none is chosen on the validation set.
RowMajorMatrix spatial_blur(const FitInput& input, std::optional<double> lambda);

/// A solver that is a trained network. The derived classes say which network, what it is
/// initialised with and what its training minimises; all else is here.
///
/// `fit` needs a training and a validation set. The fitted file (solver_file.h) has in `/network`
/// the network's weights by their names (tensor_file.h), in `/mean` and `/scale` the
/// standardisation [channels], and in the attribute `training` (JSON text) what the training
/// reported. Weights that are not those of the network that its parameters describe are refused by
/// name.
class LearnedSolver : public Solver {
 public:
  /// The settings and, once fitted, under "training" how that went.
  nlohmann::json parameters() const final;
  void check(const Sensor& sensor) const override = 0;
  bool needs_training() const final { return true; }
  void fit(const FitInput& input) final;
  FitReport fit_report() const final;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const final;
  void save(const std::filesystem::path& file) const final;
  void load(const std::filesystem::path& file, const Sensor& sensor) final;
  /// Few enough that the maps of convolutions stay in the cache.
  Eigen::Index block_frames() const override { return 64; }

 protected:
  /// `training`: the defaults of its settings.
  LearnedSolver(std::string type, const TrainingSettings& training)
      : type_(std::move(type)), standard_training_(training) {}

  /// The settings of the network and its objective.
  virtual void visit(Fields& fields) = 0;
  /// Reads all settings but the inference's.
  void read(JsonObject object);
  virtual std::shared_ptr<Network> make_network(const Sensor& sensor) const = 0;
  /// Reads "inference_precision", for networks of dense layers: libtorch has no transposed
  /// convolution in bfloat16.
  void read_inference(JsonObject& object);
  /// Overwrites what the network's constructor drew at random.
  virtual void initialise(Network&, const FitInput&, const Standardisation&) const {}
  virtual std::unique_ptr<Objective> make_objective(const FitInput& input) const = 0;
  /// Whether many frames at a time are faster as products of matrices than one after the other:
  /// where the reading of weights takes the time.
  virtual bool batches_share_weights() const { return false; }

  TrainingSettings training_;

 private:
  nlohmann::json settings() const;
  void freeze(const Sensor& sensor, std::shared_ptr<Network> network);

  std::string type_;
  TrainingSettings standard_training_;
  bool bfloat16_inference_ = false;
  Sensor sensor_;
  Standardisation standardisation_;
  std::shared_ptr<Network> network_;     ///< null before fit or load
  std::unique_ptr<InferencePlan> plan_;  ///< of frames one by one
  std::optional<FrozenGraph> graph_;     ///< of many, where batches_share_weights
  nlohmann::json result_;                ///< of the training, with what it ran on
};

}  // namespace ertbench
