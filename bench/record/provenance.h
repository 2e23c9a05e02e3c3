#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "bench/experiment/experiment.h"
#include "bench/record/date_range.h"

namespace ertbench {

std::string cpu_name();
std::string host_name();
/// Now, "2026-01-31T12:00:00Z".
std::string utc_now();

/// What this program runs on: commit, host, system, cpu, cores, compiler, library versions, date.
nlohmann::json machine_provenance();

/// What a reviewer needs to run the same again: commit, host, cpu, threads, library versions,
/// seeds, and the full recipe of every dataset. "date" is when the last of the numbers was
/// measured, "measured" when the first and the last were, "rendered" when the tables were written.
nlohmann::json provenance(const Experiment& experiment, int jobs, const DateRange& measured);

}  // namespace ertbench
