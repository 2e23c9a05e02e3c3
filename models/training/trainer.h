#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "models/networks/network.h"
#include "models/training/objective.h"
#include "models/training/training_result.h"
#include "models/training/training_set.h"
#include "models/training/validation_set.h"

namespace ertbench {

/// Where a training is watched and kept.
struct TrainingOutlet {
  std::filesystem::path folder;       ///< training.csv, and the checkpoint while it is not done
  double checkpoint_interval_s = 10;  ///< at least between two checkpoints
  double progress_interval_s = 0.5;   ///< at least between two calls of `progress`
  std::function<void(std::uint64_t done, std::uint64_t total, const std::string& text)> progress =
      {};
};

/// Trains a network by Adam; in the end it has the weights of the epoch with the least validation
/// error. After an epoch, though not more often than `checkpoint_interval_s`, all that the rest
/// depends on is put into a checkpoint; a training that finds one in its folder goes on there and
/// ends with the same weights, bit for bit, as without the interruption.
///
/// The report says "diverged" where the loss was not finite (the best weights of the epochs before
/// stand), "generator collapsed" where the network gives one image whatever the frame, or what the
/// objective found last. Throws std::runtime_error where it diverges before any epoch is done.
TrainingResult train(Network& network, Objective& objective, TrainingSet& scenes,
                     const ValidationSet& validation, const TrainingSettings& settings,
                     const TrainingOutlet& outlet);

}  // namespace ertbench
