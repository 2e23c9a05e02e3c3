#include "solvers/registry/registry.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "solvers/check/checked_solver.h"
#include "solvers/contacts/contact_solver.h"
#include "solvers/export/exported_solver.h"
#include "solvers/external/command_solver.h"
#include "solvers/iterated/gauss_newton.h"
#include "solvers/kernel/kernel_ridge.h"
#include "solvers/linear/one_step_gn.h"
#include "solvers/registry/plugin.h"
#include "solvers/total_variation/pdipm.h"

namespace ertbench {

namespace fs = std::filesystem;

namespace {

/// Others rely on it: readers of an experiment on the names, its "seeds" on the parameter "seed",
/// `ertbench check` on the seeds of what it compares by them.
void check_registration(const std::string& type, const SolverInfo& info) {
  const bool by_seeds = info.comparison == ImageComparison::seeds;
  const bool of_this_program = !info.probes.empty();  // else its images may come out equal
  if (info.has_seed() != by_seeds && (by_seeds || of_this_program)) {
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
  const MakeSolver make = [](const JsonObject& entry) {
    SolverRegistry registry;
    registry.allow_plugins();
    return registry.make(entry);
  };
  for (const auto& types :
       {linear_solvers(), total_variation_solvers(), iterated_solvers(), contact_solvers(),
        kernel_solvers(), external_solvers(), exported_solvers(make)}) {
    for (const SolverType& solver : types) add(solver.name, solver.info);
  }
  for (const char* learned : {"fcnn", "dcnn", "eit-nn", "dd-ert", "lean-net", "torchscript"}) {
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

void SolverRegistry::add_library(const fs::path& library) { not_described_.push_back(library); }

void SolverRegistry::describe_libraries() {
  for (const fs::path& library : std::exchange(not_described_, {})) describe(library);
}

void SolverRegistry::describe(const fs::path& library) {
  const PluginDescription found = describe_in_child([&] {
    SolverRegistry loaded = *this;
    loaded.load_plugin(library);
    std::vector<SolverType> brought;
    for (const auto& [type, info] : loaded.solvers_) {
      if (solvers_.count(type) == 0) brought.push_back({type, info});
    }
    return brought;
  });
  if (!found.refused.empty()) throw InputError(found.refused);
  if (!found.failed.empty()) {
    unusable_.push_back({library, found.failed});
    return;
  }
  for (const SolverType& type : found.types) {
    // A bare name would be looked for in the folders of plugins.
    const auto [place, is_new] = plugin_of_.emplace(type.name, fs::absolute(library));
    const bool own = place->second == fs::absolute(library) || place->second == library.filename();
    if (!own) {
      throw InputError(library.string() + ": two solvers are called \"" + type.name +
                       "\"; the other is in " + place->second.string() + "; rename one");
    }
    if (is_new) order_.push_back(type.name);
    described_.emplace(type.name, type.info);
  }
}

void SolverRegistry::load_plugin(const fs::path& library) { register_plugin(library, *this); }

fs::path SolverRegistry::library_of(const std::string& type) const {
  const auto plugin = plugin_of_.find(type);
  if (plugin == plugin_of_.end()) {
    throw InputError("no solver is called \"" + printable(type) + "\"; known: " + joined(order_));
  }
  if (plugin->second.has_parent_path()) return plugin->second;
  std::string folders;
  for (const auto& folder : plugin_folders()) {
    if (fs::exists(folder / plugin->second)) return folder / plugin->second;
    folders += (folders.empty() ? "" : ", ") + folder.string();
  }
  throw InputError(type + " lives in " + plugin->second.string() + ", which is not in " + folders +
                   "; build it, or name its folder in $ERTBENCH_PLUGINS");
}

const SolverInfo& SolverRegistry::load(const std::string& type) {
  const auto found = solvers_.find(type);
  if (found != solvers_.end()) return found->second;
  if (plugin_of_.count(type) == 0) describe_libraries();
  const fs::path library = library_of(type);
  if (!plugins_allowed_) {
    throw std::logic_error(type + " was to be made in a process that may not load its plugin");
  }
  load_plugin(library);
  const auto loaded = solvers_.find(type);
  if (loaded != solvers_.end()) return loaded->second;
  throw InputError(library.string() + ": holds no solver \"" + type + "\"");
}

std::unique_ptr<Solver> SolverRegistry::make(JsonObject spec) {
  const std::string type = spec.text("type");
  spec.text_or("label", type);
  const SolverInfo* info = nullptr;
  try {
    info = &load(type);
  } catch (const InputError& error) {
    spec.fail("type", error.what());
  }
  return CheckedSolver::make(type, *info, std::move(spec));
}

const SolverInfo* SolverRegistry::find_known(const std::string& type) const {
  for (const auto* infos : {&solvers_, &described_}) {
    const auto found = infos->find(type);
    if (found != infos->end()) return &found->second;
  }
  return nullptr;
}

const SolverInfo* SolverRegistry::find(const std::string& type) {
  if (const SolverInfo* const known = find_known(type)) return known;
  try {
    if (plugin_of_.count(type) == 0) {
      describe_libraries();
    } else {
      describe(library_of(type));
    }
  } catch (const InputError&) {
    return nullptr;
  }
  return find_known(type);
}

}  // namespace ertbench
