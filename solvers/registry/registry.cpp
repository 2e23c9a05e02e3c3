#include "solvers/registry/registry.h"

#include <algorithm>

#include "core/errors.h"
#include "core/json_reader.h"
#include "solvers/linear/one_step_gn.h"
#include "solvers/linear/tsvd.h"
#include "solvers/registry/plugin_library.h"
#include "solvers/total_variation/pdipm.h"

namespace ertbench {
namespace {

template <typename T>
std::unique_ptr<Solver> make_solver(JsonObject parameters) {
  return std::make_unique<T>(std::move(parameters));
}

const ParameterInfo inference_precision = {
    "inference_precision", "of the product for a frame, \"float64\" (the default) or \"float32\""};
const ParameterInfo inference_averaging = {
    "inference_averaging",
    "add the two channels of a reciprocal pair first, which halves the matrix and is exact; "
    "default true"};

const ParameterInfo inference_check = {
    "inference_check",
    "report frames that are not to be trusted (dead electrodes, noise, out of range) as suspect; "
    "default true"};
const ParameterInfo channel_mask = {
    "channel_mask",
    "channels left out of account: \"none\" (the default), a list of electrodes (from 0) whose "
    "channels are, or \"detect\": in each frame those of its dead electrodes"};

}  // namespace

SolverRegistry::SolverRegistry() {
  add(OneStepGaussNewton::type,
      {"one-step Gauss-Newton, (J'J + lambda^2 R'R)^-1 J' dv (A4)",
       {{"prior",
         "R'R: \"tikhonov\" (identity), \"noser\" (diag(J'J)^1/2), \"laplace\" (2 x the "
         "pixel graph's Laplacian); default \"noser\""},
        {"lambda",
         "weight of the prior, > 0 or \"auto\"; default \"auto\"; its unit depends on "
         "the prior, V per S/m for tikhonov and laplace"},
        channel_mask,
        inference_precision,
        inference_averaging,
        inference_check},
       make_solver<OneStepGaussNewton>,
       /*yardstick=*/true});
  add(TruncatedSvd::type,
      {"truncated singular value decomposition of J",
       {{"rank", "singular values kept, 1 ... channels / 2 or \"auto\" (the default)"},
        {"threshold",
         "in place of a rank: values down to this part of the largest are kept, "
         "between 0 and 1 or \"auto\""},
        channel_mask,
        inference_precision,
        inference_averaging,
        inference_check},
       make_solver<TruncatedSvd>});
  add(Pdipm::type,
      {"total variation by a primal-dual interior point method, min 1/2 |J x - dv|^2 + alpha |A "
       "x|_1",
       {{"alpha",
         "weight of the total variation, > 0 or \"auto\"; default \"auto\"; V^2 per (S/m "
         "x domain unit)"},
        {"tolerance", "relative duality gap at which a frame is done, 1e-8 ... 0.1; default 1e-4"},
        {"max_iterations",
         "Newton steps after which a frame is given up as not converged, 1 ... "
         "1000; default 50"},
        channel_mask,
        inference_check},
       make_solver<Pdipm>});
  for (const char* learned : {"fcnn", "dcnn", "eit-nn", "dd-ert"}) {
    add_plugin_type(learned, "libertbench_models.so");
  }
}

void SolverRegistry::add(const std::string& type, SolverInfo info) {
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
  if (const auto found = solvers_.find(type); found != solvers_.end()) return found->second;
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
      if (const auto found = solvers_.find(type); found != solvers_.end()) return found->second;
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
  return info->make(std::move(spec));
}

const SolverInfo* SolverRegistry::find(const std::string& type) {
  try {
    return &require(type);
  } catch (const InputError&) {
    return nullptr;
  }
}

}  // namespace ertbench
