#pragma once

#include <map>
#include <string>

#include "core/layers.h"
#include "solvers/export/c_source.h"

namespace ertbench {

/// The file of a solver for ONNX runtimes by its name, NAME.onnx, of opset 13: from `voltages`
/// [frames, channels] and `reference_voltages` [channels] V, which is that of the sensor's model
/// unless it is given, to `conductivity_change` [frames, rows, columns] S/m.
///
/// The format is a protobuf of a few fields, which are written here: a library for it would be a
/// dependency of the build for a hundred lines. It has no front.
std::map<std::string, std::string> onnx_file(const LayerList& list, const CExport& how);

}  // namespace ertbench
