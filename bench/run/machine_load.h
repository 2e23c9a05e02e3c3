#pragma once

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
  double busy_s_;   ///< of all cores together, since the machine was started
  double own_s_;    ///< of this process
  double start_s_;  ///< steady clock
};

}  // namespace ertbench
