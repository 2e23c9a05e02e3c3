#pragma once

#include <string>

#include "forward/data/dataset_spec.h"

namespace ertbench {

/// A dataset in a sentence, for the tables' legends.
std::string description(const DatasetSpec& spec);

}  // namespace ertbench
