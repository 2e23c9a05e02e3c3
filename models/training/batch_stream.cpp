#include "models/training/batch_stream.h"

namespace ertbench {

BatchStream::BatchStream(const TrainingSet& scenes, std::uint64_t batch, std::uint64_t batches,
                         const TrainingPlace& on)
    : scenes_(scenes), batch_(batch), batches_(batches), on_(on) {}

TrainingBatch BatchStream::drawn(std::uint64_t index) const {
  const TrainingBatch batch = scenes_.batch(index * batch_, batch_, on_.threads);
  return {batch.frames.to(on_.device), batch.truths.to(on_.device)};
}

TrainingBatch BatchStream::next() {
  if (!on_.ahead) return drawn(next_++);
  TrainingBatch batch = ahead_.valid() ? ahead_.get() : drawn(next_);
  if (++next_ < batches_) {
    ahead_ = std::async(std::launch::async, [this, index = next_] { return drawn(index); });
  }
  return batch;
}

}  // namespace ertbench
