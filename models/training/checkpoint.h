#pragma once

#include <torch/optim/adam.h>
#include <torch/optim/optimizer.h>

#include <filesystem>
#include <vector>

#include "core/arrays.h"
#include "models/networks/network.h"
#include "models/networks/tensor_file.h"
#include "models/training/trainer.h"

namespace ertbench {

/// All parameters but Network::slow_parameters, and these.
std::vector<torch::optim::OptimizerParamGroup> parameter_groups(const Network& network);

/// From now on batch normalisation uses the statistics gathered so far, not the batch's.
void freeze_statistics(Network& network);

/// What Adam remembers of its parameters, numbered through its groups: "0.steps" taken, and
/// "0.mean", "0.mean_square" of the gradient. A parameter that has not been stepped has zeros, with
/// which its first step is the same. Shares nothing with the optimiser.
NamedTensors state_of(const torch::optim::Adam& optimiser);

/// `state`: in the order of state_of for an optimiser of the same parameters.
void set_state(torch::optim::Adam& optimiser, const NamedTensors& state);

/// All that the rest of a training depends on between two epochs, at least one of which is done.
struct Checkpoint {
  TrainingResult result;
  RowMajorMatrix log;      ///< [epochs, columns] of training.csv
  NamedTensors network;    ///< weights
  NamedTensors best;       ///< weights of the best epoch
  NamedTensors optimiser;  ///< adam_state.h
  NamedTensors objective;  ///< Objective::state
};

/// Writes an HDF5 file: the attribute `result` (JSON text), `/log`, and a group of each of the
/// tensors, `/network` and so on. Throws InputError where it cannot be written.
void write_checkpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);

/// Reads one whose log has as many columns, and whose tensors have the names, types and shapes, as
/// those of `like`. Throws InputError where it is another.
Checkpoint read_checkpoint(const std::filesystem::path& file, const Checkpoint& like);

}  // namespace ertbench
