#include <CLI/CLI.hpp>
#include <cstdio>

#include "bench/cli/command.h"
#include "bench/run/reconstruct.h"
#include "bench/run/reconstruct_output.h"
#include "core/errors.h"
#include "core/text.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

struct ReconstructArguments {
  std::string solver;
  std::string input;
  std::string output;
  std::string plugin;
};

ExitCode reconstruct(const ReconstructArguments& arguments) {
  SolverRegistry registry;
  if (!arguments.plugin.empty()) {
    require_image_output(arguments.output, {arguments.plugin});
    registry.add_library(arguments.plugin);
    registry.describe_libraries();
    for (const SolverRegistry::UnusableLibrary& library : registry.unusable_libraries()) {
      throw InputError(library.file.string() + ": " + library.how + " when it was loaded; mend it");
    }
  }
  const ReconstructSummary summary =
      reconstruct_file(arguments.solver, arguments.input, arguments.output, registry);
  std::printf("%llu frames in %s, %llu not converged, %llu undefined, %llu suspect\n",
              static_cast<unsigned long long>(summary.frames),
              printable_path(arguments.output).c_str(),
              static_cast<unsigned long long>(summary.not_converged),
              static_cast<unsigned long long>(summary.undefined),
              static_cast<unsigned long long>(summary.suspect));
  const std::pair<const char*, std::uint64_t> reasons[] = {
      {"a dead electrode", summary.dead_electrode},
      {"more noise than the solver was fitted for", summary.noise},
      {"voltages out of the range that it was fitted for", summary.out_of_range},
      {"voltages that no contacts of the solver's model explain", summary.unexplained}};
  for (const auto& [reason, frames] : reasons) {
    if (frames > 0)
      std::printf("  %llu with %s\n", static_cast<unsigned long long>(frames), reason);
  }
  if (!summary.checked) {
    std::printf(
        "  frames were checked for electrodes that read zero alone: the limits of noise and range\n"
        "  need a solver that was fitted on 100 validation frames or more, by this version\n");
  }
  return done;
}

}  // namespace

Action add_reconstruct(CLI::App& command) {
  const auto arguments = std::make_shared<ReconstructArguments>();
  command.description("Images from a file of frames");
  command.add_option("--solver", arguments->solver, "One entry of a \"solvers\" list, JSON")
      ->required();
  command
      .add_option("--input", arguments->input,
                  "HDF5 with /voltages [N, 208] V and /reference_voltages [208] V")
      ->required();
  command
      .add_option("--output", arguments->output,
                  "HDF5 with /conductivity_change [N, 24, 24] S/m and /status [N];\n"
                  "of what is there, only such a file is written over")
      ->required();
  command.add_option("--plugin", arguments->plugin, "Shared library of your own solvers");
  command.footer(
      "Example:\n  echo '{\"type\": \"one-step-gn\", \"prior\": \"noser\", \"lambda\": 0.1}' > "
      "gn.json\n"
      "  ertbench reconstruct --solver gn.json --input test.h5 --output images.h5");
  return [arguments] { return reconstruct(*arguments); };
}

}  // namespace ertbench
