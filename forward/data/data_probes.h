#pragma once

#include "core/probe.h"
#include "forward/data/dataset_spec.h"

namespace ertbench {

/// The probes that a dataset depends on, by the parts of the program that make its scenes and
/// frames: the model of the sheet, and what it has of touches, sequences, faults and measured
/// frames. A new kind of scenes has its line in data_probes.cpp.
Probes data_probes(const DatasetSpec& spec);

/// All of them, as `ertbench probes` prints them.
Probes all_data_probes();

}  // namespace ertbench
