#include "bench/cluster/slurm.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>

#include "core/errors.h"
#include "core/process.h"
#include "core/regular_file.h"
#include "core/temporary_folder.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

/// What a command of Slurm's writes to standard output. Throws InputError where it fails.
std::string output_of(const std::vector<std::string>& command) {
  constexpr double most_s = 120;  // a busy controller answers late
  const TemporaryFolder folder;
  ChildProcess process(command, {folder.path() / "log", folder.path() / "output"}, {most_s});
  const ProcessEnd end = process.wait();
  if (end.ok()) return contents_of(folder.path() / "output");
  if (end.exit_code == ChildProcess::not_started) {
    throw InputError(command[0] +
                     " is not here: --engine slurm is for a machine from which jobs are submitted "
                     "(Debian: slurm-client)");
  }
  const std::string said = one_line(contents_of(folder.path() / "log"), 300);
  throw InputError(command[0] + ": " + (said.empty() ? end.text() : printable(said, 300)));
}

std::optional<long> number_in(std::string_view text) {
  long value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

long required_number(std::string_view text, const std::string& line) {
  const auto value = number_in(text);
  if (!value) throw InputError("squeue: cannot read \"" + printable(line) + "\"");
  return *value;
}

/// "3", "7-9", "0-8:4" of the array's elements.
void add_range(const std::string& range, const std::string& line, std::vector<int>& elements) {
  const std::string_view text = range;
  const std::size_t colon = text.find(':');
  const long step =
      colon == std::string_view::npos ? 1 : required_number(text.substr(colon + 1), line);
  const std::string_view ends = text.substr(0, colon);
  const std::size_t dash = ends.find('-');
  const long first = required_number(ends.substr(0, dash), line);
  const long last =
      dash == std::string_view::npos ? first : required_number(ends.substr(dash + 1), line);
  for (long i = first; i <= last; i += std::max(1L, step)) elements.push_back(static_cast<int>(i));
}

/// "[3,7-9%2]" without its brackets: the elements of an array.
std::vector<int> elements_from(std::string text, const std::string& line) {
  std::erase_if(text, [](char c) { return c == '[' || c == ']'; });
  text = text.substr(0, text.find('%'));
  std::vector<int> elements;
  for (const std::string& range : split(text, ",")) {
    if (!range.empty()) add_range(range, line, elements);
  }
  return elements;
}

}  // namespace

std::vector<SlurmTask> tasks_from(const std::string& text) {
  std::vector<SlurmTask> tasks;
  for (const std::string& line : split(text, "\n")) {
    if (line.empty()) continue;
    const std::vector<std::string> words = split(line, "|");
    if (words.size() != 4) throw InputError("squeue: cannot read \"" + printable(line) + "\"");
    SlurmTask task{required_number(words[0], line), std::nullopt, words[2], words[3]};
    if (words[1] == "N/A") {
      tasks.push_back(task);
      continue;
    }
    for (const int element : elements_from(words[1], line)) {
      task.element = element;
      tasks.push_back(task);
    }
  }
  return tasks;
}

std::vector<SlurmTask> live_tasks(std::span<const long> jobs) {
  if (jobs.empty()) return {};
  // It cuts long lists of elements short, else; those left out would be submitted once more.
  ::setenv("SLURM_BITSTR_LEN", "0", 1);
  // Not --jobs: squeue refuses the whole list for one number that the controller has forgotten.
  std::vector<SlurmTask> tasks =
      tasks_from(output_of({"squeue", "-h", "--me", "-o", "%F|%K|%T|%N"}));
  std::erase_if(tasks, [&](const SlurmTask& task) {
    return task.state == "COMPLETING" ||
           std::find(jobs.begin(), jobs.end(), task.job) == jobs.end();
  });
  return tasks;
}

long submit(const std::vector<std::string>& command) {
  const std::string said = output_of(command);
  // "12", or "12;cluster".
  const auto job = number_in(std::string_view(said).substr(0, said.find_first_of(";\n")));
  if (!job) throw InputError("sbatch: says no job's number but \"" + printable(said) + "\"");
  return *job;
}

void cancel(std::span<const long> jobs) {
  if (jobs.empty()) return;
  std::vector<std::string> command = {"scancel", "--quiet"};
  for (const long job : jobs) command.push_back(std::to_string(job));
  output_of(command);
}

int most_elements() {
  try {
    for (const std::string& line : split(output_of({"scontrol", "show", "config"}), "\n")) {
      if (!line.starts_with("MaxArraySize")) continue;
      const std::size_t equals = line.find("= ");
      if (equals == std::string::npos) break;
      if (const auto size = number_in(std::string_view(line).substr(equals + 2))) {
        return std::max(1, static_cast<int>(*size));
      }
    }
  } catch (const InputError&) {
  }
  return default_most_elements;
}

}  // namespace ertbench
