#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/frame_front.h"
#include "forward/sheet/sensor.h"
#include "solvers/export/layer_program.h"

namespace ertbench {

/// How weights are stored: float32; float16, from which they are widened in each product; or int8,
/// with integers throughout (QuantisedProgram).
enum class ExportPrecision { float32, float16, int8 };

ExportPrecision precision_from_name(const std::string& name);  ///< throws std::logic_error
const char* name_of(ExportPrecision precision);

/// The rule by which contacts are read from an image, as ContactRule of bench/score.
struct ExportedRule {
  double threshold = 0.25;  ///< of the largest change
  double floor = 0;         ///< of the background
  double saddle = 0.7;
};

struct CExport {
  std::string name = {};  ///< of the solver, for comments
  Sensor sensor = {};
  ExportPrecision precision = ExportPrecision::float32;
  ExportedRule rule = {};
  FrameFront front = {};            ///< what is done with a frame before its layers
  std::vector<double> ranges = {};  ///< for int8, ExportProgram::ranges
};

/// The files of a solver in C99 by name: fixed templates and numbers, nothing that is read from a
/// file becomes code.
std::map<std::string, std::string> c_source(const ExportProgram& program, const CExport& how);

}  // namespace ertbench
