#include "solvers/solver_file.h"

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/json.h"
#include "core/text.h"

namespace ertbench {

nlohmann::json json_attribute(const Hdf5File& file, const std::string& name) {
  try {
    return parse_json(file.read_text("/", name), file.path().string() + ": attribute " + name);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; fit it anew");
  }
}

void write_owner(Hdf5File& file, const std::string& type, const Sensor& sensor) {
  file.write_text("/", "solver", type);
  file.write_text("/", "sensor", json_text(to_json(sensor)));
}

void require_owner(const Hdf5File& file, const std::string& type, const Sensor& sensor) {
  const std::string name = file.path().string();
  if (const std::string found = file.read_text("/", "solver"); found != type) {
    throw InputError(name + ": holds a fitted \"" + printable(found) + "\", not a \"" + type +
                     "\"");
  }
  const nlohmann::json found = json_attribute(file, "sensor");
  if (sensor_from_json(JsonObject(found, name, "/sensor")) != sensor) {
    throw InputError(name + ": was fitted for the sensor " + json_text(found) + ", asked for is " +
                     json_text(to_json(sensor)) + "; fit the solver anew");
  }
}

Hdf5File create_solver_file(const std::filesystem::path& file, const std::string& type,
                            const Sensor& sensor, const nlohmann::json& parameters) {
  Hdf5File out = Hdf5File::create(file);
  write_owner(out, type, sensor);
  out.write_number("/", "format_version", solver_file_version);
  out.write_text("/", "parameters", json_text(parameters));
  return out;
}

Hdf5File open_solver_file(const std::filesystem::path& file, const std::string& type,
                          const Sensor& sensor) {
  Hdf5File in = Hdf5File::open(file);
  if (!in.has_attribute("/", "solver") || !in.has_attribute("/", "format_version")) {
    throw InputError(file.string() + ": is not the file of a fitted solver");
  }
  require_owner(in, type, sensor);
  if (const double found = in.read_number("/", "format_version"); found != solver_file_version) {
    throw InputError(file.string() + ": has format version " + std::to_string(found) +
                     ", this program reads " + std::to_string(solver_file_version) +
                     "; fit the solver anew");
  }
  return in;
}

nlohmann::json parameters_of_fit(const Hdf5File& file) {
  nlohmann::json parameters = json_attribute(file, "parameters");
  // Files of earlier versions have the parameters of the inference as well.
  for (const char* name : {"inference_precision", "inference_averaging", "inference_check"}) {
    if (parameters.is_object()) parameters.erase(name);
  }
  return parameters;
}

}  // namespace ertbench
