#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "models/networks/network.h"
#include "models/training/objective.h"
#include "models/training/training_set.h"
#include "solvers/solver.h"

namespace ertbench {

/// How a training went.
struct TrainingResult {
  FitReport report;
  int epochs = 0;      ///< finished
  int best_epoch = 0;  ///< whose weights were kept, from 1
  /// False where the best epoch is the last one that was allowed: the validation error was still
  /// falling when the budget ended, and a longer training may give a better network. A learning
  /// rate that falls to 0 by then makes that the usual end, and does not say how much is to gain.
  bool converged = true;
  double validation_error = 0;  ///< of those weights
  double seconds = 0;           ///< all its parts together, where it was interrupted
};

/// `{"status", "message", "earlier_s", "epochs", "best_epoch", "validation_error", "seconds"}`, and
/// `"converged": false` where it had not.
nlohmann::json to_json(const TrainingResult& result);
TrainingResult training_result_from_json(const nlohmann::json& json);

/// One line for each epoch of a training, written as training.csv into the work folder:
/// `epoch,loss,<terms>,validation_error,learning_rate,seconds`; losses are means over the epoch's
/// steps, seconds the epoch's own.
class TrainingLog {
 public:
  explicit TrainingLog(std::vector<std::string> columns) : columns_(std::move(columns)) {}

  void add(std::vector<double> row) { rows_.push_back(std::move(row)); }
  void write(const std::filesystem::path& folder) const;

  RowMajorMatrix rows() const;  ///< [epochs, columns]
  void set_rows(const RowMajorMatrix& rows);

 private:
  std::vector<std::string> columns_;
  std::vector<std::vector<double>> rows_;
};

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
