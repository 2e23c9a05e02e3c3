#include "solvers/check/stored_solver.h"

#include <algorithm>

#include "core/build.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {

namespace fs = std::filesystem;

std::vector<std::string> stored_solver_names() {
  std::vector<std::string> names;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(stored_solver_file("").parent_path(), absent)) {
    if (entry.path().extension() == ".fitted") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path stored_solver_file(const std::string& name, const std::string& ending) {
  return project_folder() / "results/networks" / (name + ending);
}

fs::path fitted_file(const std::string& word, const fs::path& folder) {
  std::error_code absent;
  if (fs::path file = folder / word; fs::exists(file, absent)) return file;
  const std::vector<std::string> names = stored_solver_names();
  if (std::find(names.begin(), names.end(), word) != names.end()) {
    return stored_solver_file(word);
  }
  const std::string near = nearest_word(word, names);
  throw InputError("there is no file and no fitted solver \"" + printable(word) + "\"" +
                   (near.empty() ? "" : "; did you mean \"" + near + "\"?") +
                   "; `ertbench list --fitted` shows the fitted ones");
}

}  // namespace ertbench
