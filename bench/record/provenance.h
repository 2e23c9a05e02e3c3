#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/experiment/experiment.h"

namespace ertbench {

std::string cpu_name();

/// What the numbers were made with: commit, host, system, cpu, cores, compiler, library versions,
/// date.
nlohmann::json machine_provenance();

/// What a reviewer needs to run the same again: commit, host, cpu, threads, library versions, date,
/// seeds, and the full recipe of every dataset.
nlohmann::json provenance(const Experiment& experiment, int jobs);

}  // namespace ertbench
