#include "bench/cli/command.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bench/experiment/solver_entry.h"

namespace ertbench {

std::span<const Command> commands() {
  static constexpr Command all[] = {{"run", add_run},           {"check", add_check},
                                    {"generate", add_generate}, {"reconstruct", add_reconstruct},
                                    {"publish", add_publish},   {"list", add_list},
                                    {"timing", add_timing},     {"fidelity", add_fidelity},
                                    {"limit", add_limit},       {"calibrate", add_calibrate},
                                    {"score", add_score},       {"cache", add_cache},
                                    {"live", add_live},         {"trial", add_trial},
                                    {"element", add_element}};
  return all;
}

void add_experiment(CLI::App& command, std::string& file) {
  command.add_option("EXPERIMENT.json", file)->required();
}

bool is_named(const SolverEntry& entry, const std::string& label) {
  return entry.label == label || entry.family == label;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::filesystem::path result_folder(const std::string& out, const std::string& experiment) {
  return out.empty() ? std::filesystem::path("results") / experiment : std::filesystem::path(out);
}

}  // namespace ertbench
