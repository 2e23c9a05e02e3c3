#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <stdexcept>
#include <string>

#include "bench/experiment/experiment_json.h"
#include "bench/run/runner.h"

namespace CLI {
class App;
}

namespace ertbench {

/// How the program ends. A defect is any error that nobody foresaw.
enum ExitCode {
  done = 0,
  regression = 1,
  trial_failed = 1,
  bad_input = 2,
  our_defect = 3,
  part_missing = 4  ///< a part of the program is not built, and no launcher is there to build it
};

/// Runs a command whose options were read. Throws InputError for input that cannot be used.
using Action = std::function<ExitCode()>;

/// A command of the program. `add` puts its options, help and an example into the subcommand, and
/// returns what runs it; the options live in that function. Where a part has the command, the list
/// of all commands gives the part in place of `add`, and its description; null: a hidden command.
struct Command {
  const char* name;
  Action (*add)(CLI::App& command);
  const char* part = nullptr;
  const char* description = nullptr;
};

struct SlurmOptions;
struct SlurmOutcome;

/// The contents of a part: a library beside libertbench_bench.so, or in ertbench/ beside it, that
/// is built and loaded when a command or an experiment first needs it. The table of one needs none.
/// Each is called libertbench_NAME.so and exports `ertbench_part_NAME`, which fills this in.
struct Part {
  std::span<const Command> commands;
  /// Its stages; `scenes`: of each dataset, for fidelity. Null where it has none.
  Stages (*stages)(int scenes) = nullptr;
  /// See bench/cluster/slurm.h; null in parts without it.
  SlurmOutcome (*run_on_slurm)(const Experiment& experiment, const Cache& cache,
                               const SlurmOptions& options) = nullptr;
  /// Runs an experiment on KTC2023's files and returns how many figures could not be drawn.
  std::size_t (*run_ktc2023)(const ExperimentJson& json, const std::filesystem::path& folder,
                             const std::string& command) = nullptr;
};

/// The library of a part is not there.
class PartMissing : public std::runtime_error {
 public:
  explicit PartMissing(const std::string& part);
  const std::string& part() const { return part_; }

 private:
  std::string part_;
};

/// Loads the part at the first call; later calls return the same object. Throws PartMissing where
/// its library is not there, std::runtime_error where it cannot be loaded.
const Part& part_named(const std::string& name);

}  // namespace ertbench
