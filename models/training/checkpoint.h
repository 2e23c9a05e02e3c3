#pragma once

#include <filesystem>
#include <vector>

#include "core/arrays.h"
#include "models/networks/network.h"
#include "models/networks/tensor_file.h"
#include "models/training/adam.h"
#include "models/training/trainer.h"

namespace ertbench {

/// Groups of parameters: all others first, then Network::slow_parameters.
std::vector<Adam::Group> parameter_groups(const Network& network);

/// Makes batch normalisation use the running statistics from now on, not those of the batch.
void freeze_statistics(Network& network);

/// Complete state of a training after an epoch.
struct Checkpoint {
  TrainingResult result;
  RowMajorMatrix log;      ///< [epochs, columns] of training.csv
  NamedTensors network;    ///< weights
  NamedTensors best;       ///< weights of the best epoch
  NamedTensors optimiser;  ///< Adam::state
  NamedTensors objective;  ///< Objective::state
};

/// Writes an HDF5 file with the attribute `result` (JSON text), `/log`, and a group for each list
/// of tensors (`/network`, ...). Throws InputError if it cannot be written.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

/// Reads a checkpoint whose log has as many columns, and whose tensors have the same names, types
/// and shapes, as those of `like`. Throws InputError for any other.
Checkpoint read_checkpoint(const std::filesystem::path& file, const Checkpoint& like);

}  // namespace ertbench
