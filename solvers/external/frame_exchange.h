#pragma once

#include <mutex>
#include <span>

#include "forward/sheet/sensor.h"
#include "solvers/external/program.h"
#include "solvers/solver.h"

namespace ertbench {

/// Step 3 of the protocol: n, n frames out; n images and n bytes of status in. Nothing is allocated
/// for frames and images that lie row behind row. Any number of threads, one after the other.
class FrameExchange {
 public:
  /// `program` must outlive this.
  FrameExchange(Program& program, double frame_limit_s)
      : program_(program), frame_limit_s_(frame_limit_s) {}

  /// Throws FailedTrial as Program does, and where a byte of status is no FrameStatus.
  void reconstruct(FramesView changes, ImagesView images, std::span<FrameReport> reports);

 private:
  Program& program_;
  double frame_limit_s_;
  std::mutex one_at_a_time_;
};

}  // namespace ertbench
