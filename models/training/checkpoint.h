#pragma once

#include <filesystem>

#include "core/arrays.h"
#include "models/networks/named_tensors.h"
#include "models/training/training_result.h"

namespace ertbench {

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
