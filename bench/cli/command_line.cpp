#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <new>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "bench/cli/command.h"
#include "core/build.h"
#include "core/errors.h"
#include "core/lists.h"
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
                   joined(names));
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
    if (std::ranges::find(known, word) != known.end()) continue;
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
    if (safe != word) text = replaced(text, word, safe);
  }
  return printable_lines(text, most_said);
}

/// The function that adds the command's options. Throws PartMissing where its part is not built.
Action (*add_from_part(const Command& command))(CLI::App&) {
  for (const Command& one : part_named(command.part).commands) {
    if (std::string_view(one.name) == command.name) return one.add;
  }
  throw std::runtime_error(std::string("the part \"") + command.part + "\" has no command \"" +
                           command.name + "\"");
}

/// Replaces this process by the launcher, which builds the part and calls the program with the same
/// words. Returns where there is no launcher, or where it has just tried.
void build_and_call_again(const std::string& part, char** argv) {
  const char* launcher = std::getenv("ERTBENCH_LAUNCHER");
  const char* tried = std::getenv("ERTBENCH_BUILT_PART");
  if (!launcher || (tried && part == tried)) return;
  std::string words[] = {launcher, "--build-part", part};
  std::vector<char*> call;
  for (std::string& word : words) call.push_back(word.data());
  for (char** word = argv + 1; *word; ++word) call.push_back(*word);
  call.push_back(nullptr);
  execv(launcher, call.data());
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
      "2 input that cannot be used; 3 a defect of ertbench; 4 a part of the program is not built.");
  std::vector<std::pair<CLI::App*, Action>> actions;
  for (const Command& command : commands()) {
    CLI::App* subcommand = app.add_subcommand(command.name);
    if (!command.part) {
      actions.emplace_back(subcommand, command.add(*subcommand));
      continue;
    }
    if (command.description) {
      subcommand->description(command.description);
    } else {
      subcommand->group("");  // hidden
    }
    if (argc > 1 && command.name == std::string_view(argv[1])) {
      actions.emplace_back(subcommand, add_from_part(command)(*subcommand));
    }
  }
  for (const auto& [subcommand, action] : actions) require_usable_values(*subcommand);
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
  const auto chosen =
      std::ranges::find_if(actions, [](const auto& action) { return action.first->parsed(); });
  return chosen->second();
}

constexpr const char* no_memory =
    "ertbench: not enough memory; end other programs, or choose a smaller \"count\" or \"batch\" "
    "and fewer --jobs\n";

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

/// Throws InputError if something that was printed got lost, as on a full disk.
void require_output_written() {
  std::cout.flush();
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0 && std::cout) return;
  throw InputError("the standard output could not be written" +
                   (errno != 0 ? " (" + std::generic_category().message(errno) + ")" : "") +
                   "; part of it is lost, print it again to where there is room");
}

}  // namespace

ExitCode run_command_line(int argc, char** argv) {
  std::set_terminate(ertbench::terminate);
  const auto say = [](const char* before, const std::string& text, const char* after) {
    std::fflush(stdout);  // so that in one log of both what was printed before stands before
    std::fprintf(stderr, "%s%s%s\n", before, printable_lines(text, most_said).c_str(), after);
  };
  try {
    spdlog::set_default_logger(spdlog::stderr_color_mt("ertbench"));
    spdlog::set_formatter(std::make_unique<PrintableLines>());
    const ExitCode code = parse_and_run(argc, argv);
    require_output_written();
    return code;
  } catch (const PartMissing& e) {
    build_and_call_again(e.part(), argv);
    say("ertbench: ", e.what(), "");
    return part_missing;
  } catch (const InputError& e) {
    say("", e.what(), "");
    return bad_input;
  } catch (const std::filesystem::filesystem_error& e) {
    say("", e.path1().string() + ": " + e.code().message(),
        "; check that the folder exists and can be written");
    return bad_input;
  } catch (const std::bad_alloc&) {
    std::fputs(no_memory, stderr);
    return bad_input;
  } catch (const std::system_error& e) {
    say("ertbench: the system refuses: ", e.what(),
        "; end other programs, or raise the limits of this user (ulimit -a)");
    return bad_input;
  } catch (const std::exception& e) {
    say("ertbench failed; please report this: ", e.what(), "");
    return our_defect;
  }
}

}  // namespace ertbench
