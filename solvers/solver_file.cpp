#include "solvers/solver_file.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors.h"
#include "core/json_reader.h"

namespace ertbench {
namespace {

nlohmann::json parse_attribute(const std::filesystem::path& file, const std::string& name,
                               const std::string& text) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception&) {
    throw InputError(file.string() + ": attribute " + name + ": not valid JSON; fit it anew");
  }
}

}  // namespace

Hdf5File create_solver_file(const std::filesystem::path& file, const std::string& type,
                            const Sensor& sensor, const nlohmann::json& parameters) {
  Hdf5File out = Hdf5File::create(file);
  out.write_text("/", "solver", type);
  out.write_number("/", "format_version", solver_file_version);
  out.write_text("/", "sensor", to_json(sensor).dump());
  out.write_text("/", "parameters", parameters.dump());
  return out;
}

OpenedSolverFile open_solver_file(const std::filesystem::path& file, const std::string& type,
                                  const Sensor& sensor) {
  Hdf5File in = Hdf5File::open(file);
  if (!in.has_attribute("/", "solver") || !in.has_attribute("/", "format_version")) {
    throw InputError(file.string() + ": is not the file of a fitted solver");
  }
  if (const std::string found = in.read_text("/", "solver"); found != type) {
    throw InputError(file.string() + ": holds a fitted \"" + found + "\", not a \"" + type + "\"");
  }
  if (const double found = in.read_number("/", "format_version"); found != solver_file_version) {
    throw InputError(file.string() + ": has format version " + std::to_string(found) +
                     ", this program reads " + std::to_string(solver_file_version) +
                     "; fit the solver anew");
  }
  const std::string sensor_text = in.read_text("/", "sensor");
  const nlohmann::json sensor_json = parse_attribute(file, "sensor", sensor_text);
  if (sensor_from_json(JsonObject(sensor_json, file.string(), "/sensor")) != sensor) {
    throw InputError(file.string() + ": was fitted for the sensor " + sensor_text +
                     ", asked for is " + to_json(sensor).dump() + "; fit the solver anew");
  }
  std::string parameters = in.read_text("/", "parameters");
  return {std::move(in), std::move(parameters)};
}

nlohmann::json parse_parameters(const OpenedSolverFile& opened) {
  return parse_attribute(opened.file.path(), "parameters", opened.parameters);
}

}  // namespace ertbench
