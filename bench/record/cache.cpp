#include "bench/record/cache.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/build.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "forward/data/dataset_file.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

/// The files among the words of a value, a string or a list of strings, in the order of the words.
std::vector<std::filesystem::path> files_named(const nlohmann::json& value,
                                               const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  const nlohmann::json words = value.is_array() ? value : nlohmann::json::array({value});
  for (const nlohmann::json& word : words) {
    if (!word.is_string() || word.get_ref<const std::string&>().empty()) continue;
    std::filesystem::path file = folder / word.get<std::string>();
    std::error_code error;
    if (std::filesystem::is_regular_file(file, error)) files.push_back(std::move(file));
  }
  return files;
}

}  // namespace

Cache Cache::standard() {
  const char* folder = std::getenv("ERTBENCH_CACHE");
  return Cache(folder && *folder ? std::filesystem::path(folder) : project_folder() / "cache");
}

Cache::Cache(std::filesystem::path folder, Reuse reuse)
    : folder_(std::move(folder)), reuse_(reuse) {}

std::filesystem::path Cache::dataset(const DatasetSpec& spec) const {
  return folder_ / "datasets" / (spec.name + "-" + hash_of(to_json(spec).dump()) + ".h5");
}

DatasetFile Cache::open_dataset(const DatasetSpec& spec) const {
  DatasetFile set(dataset(spec));
  if (set.recipe() != to_json(spec).dump()) {
    throw InputError(set.path().string() +
                     ": holds another dataset than its name says; remove it and run again");
  }
  return set;
}

nlohmann::json Cache::fitted_solver_key(const FitRecipe& recipe) {
  nlohmann::json solver = *recipe.entry.spec;
  solver.erase("label");
  for (const std::string& name : recipe.entry.inference_parameters) solver.erase(name);
  nlohmann::json key = {{"format_version", solver_file_version},
                        {"solver", solver},
                        {"sensor", to_json(recipe.sensor)}};
  for (const std::filesystem::path& plugin : recipe.plugins) {
    key["plugins"].push_back(hash_of_file(plugin));
  }
  for (const std::string& name : recipe.entry.file_parameters) {
    for (const std::filesystem::path& file :
         files_named(solver.value(name, nlohmann::json()), folder_of_source(recipe.source))) {
      key["files"].push_back(hash_of_file(file));
    }
  }
  if (recipe.training) key["training"] = to_json(*recipe.training);
  if (recipe.validation) key["validation"] = to_json(*recipe.validation);
  return key;
}

std::filesystem::path Cache::fitted_solver(const FitRecipe& recipe) const {
  const std::string hash = hash_of(fitted_solver_key(recipe).dump());
  return folder_ / "solvers" / (recipe.entry.type + "-" + hash + ".fitted");
}

std::filesystem::path Cache::work_folder(const FitRecipe& recipe) const {
  return fitted_solver(recipe).replace_extension(".work");
}

}  // namespace ertbench
