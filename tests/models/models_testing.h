#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>

#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench::testing {

inline std::unique_ptr<Solver> make_learned(const nlohmann::json& spec) {
  SolverRegistry registry;
  registry.load_plugin(ERTBENCH_MODELS_PLUGIN);
  return registry.make(JsonObject(spec, "spec.json", ""));
}

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A small training and validation set in files, and the input of a fit that uses them.
class TrainingFiles {
 public:
  explicit TrainingFiles(std::uint64_t training = 96, std::uint64_t validation = 40)
      : training_(write(training, "train")), validation_(write(validation, "validation")) {
    std::filesystem::create_directories(folder_ / "work");
  }

  FitInput input() const {
    FitInput input;
    input.training = &training_;
    input.validation = &validation_;
    input.work_folder = folder_ / "work";
    return input;
  }
  const TemporaryFolder& folder() const { return folder_; }

 private:
  DatasetFile write(std::uint64_t count, const std::string& name) {
    DatasetSpec spec = random_contacts(count, {}, 0.05);
    spec.name = name;
    generate_dataset(spec, folder_ / (name + ".h5"));
    return DatasetFile(folder_ / (name + ".h5"));
  }

  TemporaryFolder folder_;
  DatasetFile training_;
  DatasetFile validation_;
};

}  // namespace ertbench::testing
