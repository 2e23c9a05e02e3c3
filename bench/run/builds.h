#pragma once

#include "bench/record/experiment_results.h"
#include "bench/run/job_records.h"
#include "bench/run/stage.h"

namespace ertbench {

/// Notes in the results which builds made the stage's records: in the rows of each job's solver,
/// and in the list of all.
void add_builds(const Stage& stage, const Experiment& experiment, const JobRecords& records,
                ExperimentResults& results);

}  // namespace ertbench
