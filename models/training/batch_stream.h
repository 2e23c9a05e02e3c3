#pragma once

#include <torch/types.h>

#include <cstdint>
#include <future>

#include "models/training/training_set.h"

namespace ertbench {

/// Where a training runs. The frames are drawn on the CPU everywhere, so that they are the same.
struct TrainingPlace {
  torch::Device device = torch::kCPU;
  int threads = 1;     ///< that draw a batch; whatever their number, the batch is the same
  bool ahead = false;  ///< draw the next batch while the network learns from the last
};

/// The batches of an epoch in their order, on the device of the training.
class BatchStream {
 public:
  /// `scenes` outlives it, and begins no other epoch meanwhile.
  BatchStream(const TrainingSet& scenes, std::uint64_t batch, std::uint64_t batches,
              const TrainingPlace& on);
  /// At most `batches` times.
  TrainingBatch next();

 private:
  TrainingBatch drawn(std::uint64_t index) const;

  const TrainingSet& scenes_;
  std::uint64_t batch_;
  std::uint64_t batches_;
  TrainingPlace on_;
  std::uint64_t next_ = 0;
  std::future<TrainingBatch> ahead_;
};

}  // namespace ertbench
