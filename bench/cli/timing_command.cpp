#include <CLI/CLI.hpp>

#include "bench/cli/command.h"
#include "bench/timing/timing.h"

namespace ertbench {
namespace {

struct TimingArguments {
  std::string filter;
  std::string out;
  int rounds = 3;
};

ExitCode timing(const TimingArguments& arguments) {
  TimingOptions options;
  options.filter = arguments.filter;
  options.rounds = arguments.rounds;
  if (!arguments.out.empty()) options.out = arguments.out;
  return run_timing(options) > 0 ? trial_failed : done;
}

}  // namespace

Action add_timing(CLI::App& command) {
  const auto arguments = std::make_shared<TimingArguments>();
  command.description("Run the timing benchmarks, beside the limits of this machine");
  command.add_option("FILTER", arguments->filter,
                     "Regular expression of names; default: all, several minutes");
  command.add_option("--out", arguments->out, "JSON file to write (default: results/timing.json)");
  command
      .add_option("--rounds", arguments->rounds,
                  "Rounds of all benchmark programs, of which the median counts (default: 3)")
      ->check(CLI::Range(1, 99));
  command.footer(
      "Example:\n  ertbench timing 'reconstruct/(tsvd|fcnn)' --out timing.json\n"
      "The machine should be otherwise idle. \"0.80 of stream\" means that the least time this\n"
      "machine allows, here for reading the matrices once, is 0.80 of what was measured.");
  return [arguments] { return timing(*arguments); };
}

}  // namespace ertbench
