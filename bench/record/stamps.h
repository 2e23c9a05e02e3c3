#pragma once

#include "bench/experiment/experiment.h"
#include "bench/experiment/solver_entry.h"
#include "core/build_stamp.h"

/// The stamps of what this program makes: for each kind of thing the probes that it depends on.
namespace ertbench {

BuildStamp stamp_of_dataset(const DatasetSpec& spec);

/// Its solver's probe, those of the sets that it learns from, and the user's libraries.
BuildStamp stamp_of_fit(const FitRecipe& recipe);

/// The scores, the datasets of the experiment, and the solver of the job's entry, null where a job
/// runs none; with ladders or faults the front, too.
BuildStamp stamp_of_record(const Experiment& experiment, const SolverEntry* entry);

/// The probe "limit" where this program has computed it, which `ertbench limit` does, and those of
/// the test set and of the set whose scenes are the prior.
BuildStamp stamp_of_limit(const DatasetSpec& set, const DatasetSpec& scenes);

/// Today's values of the probes that a stamp carries; those that it does not know are
/// left out.
Probes current_probes(const BuildStamp& made);

/// All probes below the limit's.
Probes all_probes();

}  // namespace ertbench
