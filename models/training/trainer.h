#pragma once

#include <torch/types.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "models/networks/network.h"
#include "models/training/objective.h"
#include "models/training/training_set.h"
#include "solvers/solver.h"

namespace ertbench {

/// Result of a training.
struct TrainingResult {
  FitReport report;
  int epochs = 0;      ///< finished
  int best_epoch = 0;  ///< the epoch whose weights were kept, from 1
  /// False if the best epoch is the last of the budget: the validation error was still decreasing,
  /// and a longer training may give a better network. That is usual with a learning rate that
  /// decreases to 0, and does not quantify the possible gain.
  bool converged = true;
  double validation_error = 0;  ///< of those weights
  double seconds = 0;           ///< total over interruptions
};

/// `{"status", "message", "earlier_s", "epochs", "best_epoch", "validation_error", "seconds"}`, and
/// `"converged": false` if it had not converged.
nlohmann::json to_json(const TrainingResult& result);
TrainingResult training_result_from_json(const nlohmann::json& json);

/// Where a training runs. The frames are drawn on the CPU everywhere, so that they are the same.
struct TrainingPlace {
  torch::Device device = torch::kCPU;
  int threads = 1;     ///< that draw a batch; whatever their number, the batch is the same
  bool ahead = false;  ///< draw the next batch while the network learns from the last
};

/// Files and progress of a training, and where it runs.
struct TrainingOutlet {
  std::filesystem::path folder;       ///< training.csv, and the checkpoint while it is not done
  double checkpoint_interval_s = 10;  ///< at least between two checkpoints
  double progress_interval_s = 0.5;   ///< at least between two calls of `progress`
  std::function<void(std::uint64_t done, std::uint64_t total, const std::string& text)> progress =
      {};
  TrainingPlace on = {};
};

/// Trains a network by Adam and leaves it with the weights of the epoch with the least validation
/// error. Writes a checkpoint after an epoch, at most once in `checkpoint_interval_s`. A training
/// that finds a checkpoint in its folder continues it and ends with the same weights, bit for bit,
/// as without the interruption. The network is on the CPU before and after it.
///
/// The log, training.csv in the folder, has a line for each epoch: `epoch,loss,<terms>,
/// validation_error,learning_rate,seconds`; losses are means over the epoch's steps, seconds the
/// epoch's own.
///
/// The report's status is "diverged" if the loss was not finite (the best weights so far are kept),
/// "generator collapsed" if the network gives the same image for all frames, or the objective's
/// last problem. Throws std::runtime_error if the first epoch diverges.
TrainingResult train(Network& network, Objective& objective, TrainingSet& scenes,
                     const ValidationSet& validation, const TrainingSettings& settings,
                     const TrainingOutlet& outlet);

}  // namespace ertbench
