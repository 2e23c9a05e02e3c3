#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/hdf5_file.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// The file of a fitted solver. The root has the attributes `solver` (its type), `format_version`,
/// `sensor` and `parameters` (JSON text). The solver's arrays are datasets; CheckedSolver adds
/// `/frame_check`.
inline constexpr int solver_file_version = 1;

Hdf5File create_solver_file(const std::filesystem::path& file, const std::string& type,
                            const Sensor& sensor, const nlohmann::json& parameters);

/// Opens a file for the solver `type` on `sensor`. Throws InputError if it is no solver file, or of
/// another type, version or sensor.
Hdf5File open_solver_file(const std::filesystem::path& file, const std::string& type,
                          const Sensor& sensor);

/// Reads an attribute of the root with JSON text. Throws InputError if it is missing or not JSON.
nlohmann::json json_attribute(const Hdf5File& file, const std::string& name);

/// Reads the parameters of the fit. Throws InputError if they are not JSON.
nlohmann::json parameters_of_fit(const Hdf5File& file);

/// Writes the attributes `solver` and `sensor`.
void write_owner(Hdf5File& file, const std::string& type, const Sensor& sensor);
/// Throws InputError if these attributes name another type of solver or another sensor.
void require_owner(const Hdf5File& file, const std::string& type, const Sensor& sensor);

}  // namespace ertbench
