#pragma once

#include <map>
#include <string>

#include "runtime/layer_file.h"
#include "solvers/export/c_source.h"

namespace ertbench {

/// What exported code needs of the sensor and of the rule for contacts; without layers.
runtime::LayerFile sensor_and_rule(const CExport& how);

/// The file of a solver for `ertbench::runtime` by its name, NAME.ert.
std::map<std::string, std::string> runtime_file(const LayerList& list, const CExport& how);

}  // namespace ertbench
