#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/features/parts.h"
#include "bench/record/cache.h"
#include "frames/own_frames.h"

namespace ertbench {

/// All commands, in the order of the help.
std::span<const Command> commands();

/// Reads the command line and runs its command; every error ends in a message and a code.
ExitCode run_command_line(int argc, char** argv);

// The commands of the program itself; the others are in parts (bench/features/parts.h).
Action add_run(CLI::App& command);
Action add_report(CLI::App& command);
Action add_trial(CLI::App& command);
Action add_generate(CLI::App& command);
Action add_cache(CLI::App& command);
Action add_list(CLI::App& command);
Action add_reconstruct(CLI::App& command);
Action add_calibrate(CLI::App& command);
Action add_score(CLI::App& command);
// Those of the part "tools", which is made of several files.
Action add_check(CLI::App& command);
Action add_publish(CLI::App& command);
Action add_timing(CLI::App& command);
Action add_fidelity(CLI::App& command);
Action add_export(CLI::App& command);

// Shared by several commands.

/// Adds the positional EXPERIMENT.json.
void add_experiment(CLI::App& command, std::string& file);
/// `out`, or results/`experiment` where it is empty. Throws InputError if `out` has files that no
/// command of this program left there.
std::filesystem::path result_folder(const std::string& out, const std::string& experiment);

/// The options by which `reconstruct` and `calibrate` are told how frames are declared. Files are
/// checked when they are read. `options` must outlive the command.
void add_frame_options(CLI::App& command, OwnFramesOptions& options);

/// Has all options that have been added refuse empty values, those of unset shell variables, and
/// numbers that are NaN, which CLI::Range takes, or infinite.
void require_usable_values(CLI::App& command);

/// `--device`: what the "device" of trainings is where a solver leaves it at "auto". It is passed
/// on to the trials by the environment (ERTBENCH_DEVICE).
void add_device(CLI::App& command);

/// The overrides (`--set`) that have the experiment's networks trained in `precision` ("float32")
/// where its file has them trained in bfloat16: "/solvers/13/precision=float32".
std::vector<std::string> precision_overrides(const Experiment& experiment,
                                             const std::string& precision);

/// Warns of trainings that may take many times as long here as elsewhere: in bfloat16, on a
/// processor without it, and not in the cache. `only`: labels or families that are run; empty: all.
void warn_of_slow_trainings(const Experiment& experiment, const Cache& cache,
                            const std::vector<std::string>& only = {});

}  // namespace ertbench
