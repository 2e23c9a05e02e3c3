#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/hdf5_file.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The file of a fitted solver. Attributes of the root: `solver` (its type), `format_version`,
/// `sensor` and `parameters` (JSON text); the solver's arrays are datasets beside them, and in
/// `/frame_check` what CheckedSolver adds.
inline constexpr int solver_file_version = 1;

Hdf5File create_solver_file(const std::filesystem::path& file, const std::string& type,
                            const Sensor& sensor, const nlohmann::json& parameters);

/// Opens a file for the solver `type` on `sensor`. Throws InputError where it is not a solver file,
/// or one of another type, version or sensor.
Hdf5File open_solver_file(const std::filesystem::path& file, const std::string& type,
                          const Sensor& sensor);

/// An attribute of the root that is JSON text. Throws InputError where it is missing or is not
/// JSON.
nlohmann::json json_attribute(const Hdf5File& file, const std::string& name);

/// The parameters of the fit in an opened file. Throws InputError where they are not JSON.
nlohmann::json parameters_of_fit(const Hdf5File& file);

/// Writes whose fitted solver this is: the attributes `solver` and `sensor`.
void write_owner(Hdf5File& file, const std::string& type, const Sensor& sensor);
/// Throws InputError where the file says that it is another solver's, or for another sensor.
void require_owner(const Hdf5File& file, const std::string& type, const Sensor& sensor);

}  // namespace ertbench
