#pragma once

#include "bench/run/stage.h"
#include "core/seconds.h"

namespace ertbench {

/// Cores that this process may run on: those of its affinity (taskset, a container's or a job's set
/// of processors), at least 1. More threads than that wait for each other.
int usable_cores();

/// How busy others keep the machine while this process works: from the construction on.
class MachineLoad {
 public:
  MachineLoad();

  /// Cores that were busy on the average since, less what this process had of them; 0 where the
  /// system does not say (/proc/stat), or where it was less than its clock resolves.
  double others_cores() const;

 private:
  double busy_s_;  ///< of all cores together, since the machine was started
  double own_s_;   ///< of this process
  SteadyClock::time_point start_;
};

/// Time of a fixed piece of work on one thread, the product of a 576 x 104 matrix and a vector in
/// double precision: what a linear solver does for one frame. Median of many, µs. Latencies divided
/// by it can be compared from one machine to the next, roughly.
double calibration_us();

/// Whose times a run takes as they are: of processors like this machine's alone, or of any, as the
/// nodes of a cluster may have, where the rows say which.
enum class Machines { this_one, any };

/// Times every fitted solver, one frame at a time on one thread, then on batches. The frames are
/// shared out among rounds, and those of all solvers run in turn, so that what disturbs the machine
/// for a while falls on all of them. Its results are the rows' times.
std::unique_ptr<Stage> timing_stage(Machines machines = Machines::this_one);

}  // namespace ertbench
