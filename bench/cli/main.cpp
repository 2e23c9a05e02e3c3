// ertbench: reconstruction methods of tomographic tactile skins, compared.
//
//   ertbench run experiments/quick.json
//   ertbench generate experiments/table_c1.json --dataset test --out test.h5
//   ertbench reconstruct --solver solver.json --input frames.h5 --output images.h5
//   ertbench check experiments/quick.json
//   ertbench list
//   ertbench timing 'reconstruct/tsvd'

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "bench/cli/command.h"
#include "core/build.h"
#include "core/errors.h"

namespace ertbench {
namespace {

/// A word that is no command gets an answer of its own: CLI11 would only say that it expected one.
void require_command(const CLI::App& app, const std::string& word) {
  if (word.empty() || word[0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == word) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  throw InputError("no command is called \"" + word + "\"; there are " + list_of(names));
}

ExitCode parse_and_run(int argc, char** argv) {
  CLI::App app{"Compares reconstruction methods for tomographic tactile skins.", "ertbench"};
  app.require_subcommand(1);
  app.set_version_flag("--version", commit_text(this_build().commit, this_build().dirty));
  app.footer(
      "`ertbench COMMAND --help` shows an example of each command.\n"
      "Exit codes: 0 done; 1 a trial or a figure failed, or a check found something worse;\n"
      "2 input that cannot be used; 3 a defect of ertbench.");
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Command& command : commands()) {
    CLI::App* subcommand = app.add_subcommand(command.name);
    actions.emplace_back(subcommand, command.add(*subcommand));
  }
  require_command(app, argc > 1 ? argv[1] : "");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? done : bad_input;
  }
  const auto chosen = std::find_if(actions.begin(), actions.end(),
                                   [](const auto& action) { return action.first->parsed(); });
  return chosen->second();
}

}  // namespace
}  // namespace ertbench

#ifdef __SANITIZE_ADDRESS__
// libhdf5 loses a few hundred bytes when it refuses some damaged files.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
#endif

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("ertbench"));
  spdlog::set_pattern("%^%l%$: %v");
  try {
    return ertbench::parse_and_run(argc, argv);
  } catch (const ertbench::InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return ertbench::bad_input;
  } catch (const std::filesystem::filesystem_error& e) {
    std::fprintf(stderr, "%s: %s; check that the folder exists and can be written\n",
                 e.path1().c_str(), e.code().message().c_str());
    return ertbench::bad_input;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "ertbench failed; please report this: %s\n", e.what());
    return ertbench::our_defect;
  }
}
