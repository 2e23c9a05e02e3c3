#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/arrays.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

class SceneModel;

/// Scenes of a set as arrays, rows [first, first + count): what a block of the file holds.
struct DatasetBlock {
  Frames voltages;        ///< [count, channels] V, with noise and faults
  Frames clean_voltages;  ///< [count, channels] V, with faults of the sheet alone
  Images conductivity;    ///< [count, image pixels] S/m, the truth
  RowMajorMatrix effort;  ///< [count, 2] of SceneModel::solve; no columns for a grid
  RowMajorMatrix contacts;
  RowMajorMatrix vertices;
  RowMajorMatrix forces;      ///< [count, contacts] N; no columns where nothing has a force
  RowMajorMatrix moments;     ///< [count, 2] /time and /sequence; no columns where nothing moves
  std::vector<Scene> truths;  ///< [count]
};

/// `model` has the spec's sensor and SheetModel. The numbers depend on the spec alone, not on
/// threads or on where blocks begin.
DatasetBlock generate_block(const DatasetSpec& spec, const SceneModel& model, std::uint64_t first,
                            std::uint64_t count, int threads = 1);

}  // namespace ertbench
