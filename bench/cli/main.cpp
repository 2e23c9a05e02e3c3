// ertbench: reconstruction methods of tomographic tactile skins, compared.
//
//   ertbench run experiments/quick.json
//   ertbench generate experiments/table_c1.json --dataset test --out test.h5
//   ertbench reconstruct --solver solver.json --input frames.h5 --output images.h5
//   ertbench check experiments/quick.json
//   ertbench list
//   ertbench timing 'reconstruct/tsvd'

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <sstream>
#include <system_error>

#include "bench/cli/command.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

constexpr std::size_t most_said = 8000;  ///< characters of a message, a library's among them

/// A word that is no command gets an answer of its own: CLI11 would only say that it expected one.
void require_command(const CLI::App& app, const std::string& word) {
  if (word.empty() || word[0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) {
    if (command->get_name() == word) return;
    if (!command->get_group().empty()) names.push_back(command->get_name());
  }
  const std::string near = nearest_word(word, names);
  throw InputError("no command is called \"" + printable(word) + "\"" +
                   (near.empty() ? "" : "; did you mean \"" + near + "\"?") + "; there are " +
                   list_of(names));
}

/// For a command line with an option that nobody knows: the one that it may be a slip for; else
/// empty.
std::string suggestion(const CLI::App& app, int argc, char** argv) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  if (chosen.empty()) return "";
  std::vector<std::string> known;
  for (const CLI::Option* option : chosen.front()->get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  for (int i = 2; i < argc; ++i) {
    const std::string word = std::string(argv[i]).substr(0, std::string(argv[i]).find('='));
    if (!word.starts_with("--") || word == "--") continue;
    if (std::find(known.begin(), known.end(), word) != known.end()) continue;
    const std::string near = nearest_word(word, known);
    if (!near.empty()) return "Did you mean " + near + "?\n";
  }
  return "";
}

/// Lines of the log as a terminal may have them, whatever the texts in them are.
class PrintableLines : public spdlog::formatter {
 public:
  PrintableLines() : lines_("%^%l%$: %v") {}

  void format(const spdlog::details::log_msg& message, spdlog::memory_buf_t& out) override {
    const std::string text =
        printable_lines({message.payload.data(), message.payload.size()}, most_said);
    spdlog::details::log_msg safe = message;
    safe.payload = text;
    lines_.format(safe, out);
    message.color_range_start = safe.color_range_start;
    message.color_range_end = safe.color_range_end;
  }

  std::unique_ptr<spdlog::formatter> clone() const override {
    return std::make_unique<PrintableLines>();
  }

 private:
  spdlog::pattern_formatter lines_;
};

/// What the library that reads the command line says, with the words of it as they may be shown.
std::string shown(std::string text, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string safe = printable(word);
    if (safe == word) continue;
    for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at)) {
      text.replace(at, word.size(), safe);
      at += safe.size();
    }
  }
  return printable_lines(text, most_said);
}

ExitCode parse_and_run(int argc, char** argv) {
  CLI::App app{"Compares reconstruction methods for tomographic tactile skins.", "ertbench"};
  app.require_subcommand(1);
  app.set_version_flag("--version", std::string("ertbench " ERTBENCH_VERSION " (commit ") +
                                        commit_text(this_build().commit, this_build().dirty) + ")");
  app.footer(
      "`ertbench COMMAND --help` shows an example of each command.\n"
      "Environment: ERTBENCH_CACHE, the folder of datasets and fitted solvers (else cache/ of the\n"
      "project); ERTBENCH_YES=1, the launcher installs missing packages without asking; TMPDIR.\n"
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
    std::ostringstream help;
    std::ostringstream mistake;
    const ExitCode code = app.exit(e, help, mistake) == 0 ? done : bad_input;
    std::fputs(help.str().c_str(), stdout);
    std::fputs(shown(mistake.str(), argc, argv).c_str(), stderr);
    if (code != done) std::fputs(suggestion(app, argc, argv).c_str(), stderr);
    return code;
  }
  const auto chosen = std::find_if(actions.begin(), actions.end(),
                                   [](const auto& action) { return action.first->parsed(); });
  return chosen->second();
}

constexpr const char* no_memory =
    "ertbench: not enough memory; end other programs, or choose a smaller \"count\" or \"batch\" "
    "and "
    "fewer --jobs\n";

/// Lack of memory may also show where no exception can leave: values of JSON need some to be
/// destroyed.
[[noreturn]] void terminate() {
  try {
    if (std::current_exception()) std::rethrow_exception(std::current_exception());
  } catch (const std::bad_alloc&) {
    std::fputs(no_memory, stderr);
    std::_Exit(bad_input);
  } catch (...) {
  }
  std::abort();
}

}  // namespace
}  // namespace ertbench

// For builds with the leak sanitizer, which asks the program itself by these names: libhdf5 loses a
// few hundred bytes when it refuses some damaged files.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5\n"; }
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }

int main(int argc, char** argv) {
  std::set_terminate(ertbench::terminate);
  const auto say = [](const char* before, const std::string& text, const char* after) {
    std::fprintf(stderr, "%s%s%s\n", before,
                 ertbench::printable_lines(text, ertbench::most_said).c_str(), after);
  };
  try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("ertbench"));
    spdlog::set_formatter(std::make_unique<ertbench::PrintableLines>());
    return ertbench::parse_and_run(argc, argv);
  } catch (const ertbench::InputError& e) {
    say("", e.what(), "");
    return ertbench::bad_input;
  } catch (const std::filesystem::filesystem_error& e) {
    say("", e.path1().string() + ": " + e.code().message(),
        "; check that the folder exists and can be written");
    return ertbench::bad_input;
  } catch (const std::bad_alloc&) {
    std::fputs(ertbench::no_memory, stderr);
    return ertbench::bad_input;
  } catch (const std::system_error& e) {
    say("ertbench: the system refuses: ", e.what(),
        "; end other programs, or raise the limits of this user (ulimit -a)");
    return ertbench::bad_input;
  } catch (const std::exception& e) {
    say("ertbench failed; please report this: ", e.what(), "");
    return ertbench::our_defect;
  }
}
