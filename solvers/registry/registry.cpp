#include "solvers/registry/registry.h"

#include <algorithm>

#include "core/errors.h"
#include "core/json_reader.h"
#include "solvers/check/checked_solver.h"
#include "solvers/linear/registration.h"
#include "solvers/registry/plugin_library.h"
#include "solvers/total_variation/registration.h"

namespace ertbench {
namespace {

/// Others rely on it: readers of an experiment on the names, its "seeds" on the parameter "seed",
/// `ertbench check` on the seeds of what it compares by them.
void check_registration(const std::string& type, const SolverInfo& info) {
  if (info.has_seed() != (info.comparison == ImageComparison::seeds)) {
    throw InputError(type +
                     ": images are to be compared by seeds where a parameter has the role "
                     "seed, and only there; set both or none");
  }
  for (const ParameterInfo& parameter : info.parameters) {
    const bool inference = parameter.name.starts_with("inference_");
    const bool seed = parameter.name == "seed";
    if (inference == (parameter.role == ParameterRole::inference) &&
        seed == (parameter.role == ParameterRole::seed)) {
      continue;
    }
    throw InputError(type + ": parameter \"" + parameter.name +
                     "\": the roles inference and seed belong to parameters whose names begin with "
                     "\"inference_\" or are \"seed\", and to these alone; rename it or give it its "
                     "role");
  }
}

}  // namespace

// A type of solvers that the program can name stands in one of these lines, and nowhere else
// outside its own folder.
SolverRegistry::SolverRegistry() {
  for (const std::vector<SolverType>& room : {linear_solvers(), total_variation_solvers()}) {
    for (const SolverType& solver : room) add(solver.name, solver.info);
  }
  for (const char* learned : {"fcnn", "dcnn", "eit-nn", "dd-ert"}) {
    add_plugin_type(learned, "libertbench_models.so");
  }
}

void SolverRegistry::add(const std::string& type, SolverInfo info) {
  for (ParameterInfo& shared : CheckedSolver::own_parameters()) {
    info.parameters.push_back(std::move(shared));
  }
  check_registration(type, info);
  if (!solvers_.emplace(type, std::move(info)).second) {
    throw InputError("two solvers are called \"" + type + "\"; rename one");
  }
  if (std::find(order_.begin(), order_.end(), type) == order_.end()) order_.push_back(type);
}

void SolverRegistry::add_plugin_type(const std::string& type, const std::string& library) {
  plugin_of_[type] = library;
  if (std::find(order_.begin(), order_.end(), type) == order_.end()) order_.push_back(type);
}

void SolverRegistry::load_plugin(const std::filesystem::path& library) {
  register_plugin(library, *this);
}

const SolverInfo& SolverRegistry::require(const std::string& type) {
  if (const SolverInfo* const found = find_loaded(type)) return *found;
  const auto plugin = plugin_of_.find(type);
  if (plugin == plugin_of_.end()) {
    std::string known;
    for (const auto& name : order_) known += (known.empty() ? "" : ", ") + name;
    throw InputError("no solver is called \"" + type + "\"; known: " + known);
  }
  std::string folders;
  for (const auto& folder : plugin_folders()) {
    if (std::filesystem::exists(folder / plugin->second)) {
      load_plugin(folder / plugin->second);
      if (const SolverInfo* const found = find_loaded(type)) return *found;
      throw InputError((folder / plugin->second).string() + ": holds no solver \"" + type + "\"");
    }
    folders += (folders.empty() ? "" : ", ") + folder.string();
  }
  throw InputError(type + " lives in " + plugin->second + ", which is not in " + folders +
                   "; build it, or name its folder in $ERTBENCH_PLUGINS");
}

std::unique_ptr<Solver> SolverRegistry::make(JsonObject spec) {
  const std::string type = spec.text("type");
  spec.text_or("label", type);
  const SolverInfo* info = nullptr;
  try {
    info = &require(type);
  } catch (const InputError& error) {
    spec.fail("type", error.what());
  }
  return CheckedSolver::make(type, *info, std::move(spec));
}

const SolverInfo* SolverRegistry::find_loaded(const std::string& type) const {
  const auto found = solvers_.find(type);
  return found == solvers_.end() ? nullptr : &found->second;
}

const SolverInfo* SolverRegistry::find(const std::string& type) {
  try {
    return &require(type);
  } catch (const InputError&) {
    return nullptr;
  }
}

}  // namespace ertbench
