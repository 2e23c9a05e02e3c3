#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/hdf5_file.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The file of a fitted solver. Attributes of the root: `solver` (its type), `format_version`,
/// `sensor` and `parameters` (JSON text); the solver's arrays are datasets beside them.
inline constexpr int solver_file_version = 1;

Hdf5File create_solver_file(const std::filesystem::path& file, const std::string& type,
                            const Sensor& sensor, const nlohmann::json& parameters);

struct OpenedSolverFile {
  Hdf5File file;
  std::string parameters;  ///< JSON text
};

/// Opens a file for the solver `type` on `sensor`. Throws InputError where it is not a solver file,
/// or one of another type, version or sensor.
OpenedSolverFile open_solver_file(const std::filesystem::path& file, const std::string& type,
                                  const Sensor& sensor);

/// The parameters as JSON. Throws InputError where the text is not a JSON object.
nlohmann::json parse_parameters(const OpenedSolverFile& opened);

}  // namespace ertbench
