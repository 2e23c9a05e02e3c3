#pragma once

#include <filesystem>
#include <string>

#include "bench/experiment/solver_entry.h"

namespace ertbench {

/// What a stage has done in one process. `name` is its identity: `ertbench trial` is told it, and
/// its record, its log and its progress are files of that name.
struct Job {
  std::string name;     ///< unique among all stages: "tsvd.timing.2", "train.fidelity"
  std::string subject;  ///< what it is about, in all rounds the same: "tsvd", "train"
  std::string title;    ///< that for people: "dd-ert seed 2"
  const SolverEntry* entry = nullptr;  ///< whose solver it runs; null where it runs none
  int round = 0;                       ///< of a stage that comes back to a subject, from 0
};

}  // namespace ertbench
