#pragma once

#include <map>
#include <string>

#include "solvers/export/c_source.h"
#include "solvers/solver.h"

namespace ertbench {

/// The matrix of a linear method, image = matrix (voltages - reference_voltages), as `matrix.npz`
/// (`matrix` [pixels, channels] S/m per V, `reference_voltages` [channels] V, `image` [2] rows and
/// columns) and `matrix.csv`, a pixel a line. Throws InputError for int8, and for `program` with
/// more than linear layers.
std::map<std::string, std::string> matrix_files(const ExportProgram& program, const Solver& solver,
                                                const Sensor& sensor, ExportPrecision precision);

}  // namespace ertbench
