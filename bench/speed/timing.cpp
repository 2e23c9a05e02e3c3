#include "bench/speed/timing.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "bench/record/record_file.h"
#include "bench/speed/benchmark_output.h"
#include "bench/table/table.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* note =
    "time_s is the median of rounds_s: processor time, but wall time where the name says "
    "real_time. limit_us is the least time that the machine allows by what \"label\" names, "
    "of_limit that over the measured time. library_build_type \"debug\" is how Debian built Google "
    "Benchmark 1.7.1; how ertbench was built is ertbench_build_type. NaN, which that version "
    "writes "
    "bare, is null here.";

struct Program {
  BenchmarkProcess process;
  std::uint64_t count = 0;  ///< benchmarks per round, including limits
  json context;
  std::string failure;  ///< empty: none so far
};

/// Calls `work` and records its failure in the program.
template <typename Work>
void attempt(Program& program, const Work& work) {
  try {
    work();
  } catch (const std::runtime_error& error) {
    program.failure = error.what();
    program.count = 0;
    std::fprintf(stderr, "%s %s\n", program.process.name().c_str(),
                 printable_lines(error.what()).c_str());
  }
}

/// Adds the machine's limits, with which results are compared. A leading '-' already keeps them.
std::string with_limits(const std::string& filter) {
  return filter.empty() || filter[0] == '-' ? filter : "(" + filter + ")|^limit/";
}

std::vector<Program> find_programs(const fs::path& folder, const fs::path& temporary) {
  std::vector<Program> programs;
  for (const std::string& name : benchmark_programs()) {
    const fs::path file = folder / name;
    if (::access(file.c_str(), X_OK) != 0) {
      throw InputError(file.string() +
                       ": is missing or cannot be run; build it with `cmake --build " +
                       folder.parent_path().string() +
                       " --target ertbench_benchmarks` (the options ERTBENCH_BENCHMARKS and "
                       "ERTBENCH_MODELS on), which `./ertbench timing` does by itself");
    }
    programs.push_back({BenchmarkProcess(file, temporary), 0, nullptr, ""});
  }
  return programs;
}

[[noreturn]] void refuse(const std::string& filter, std::vector<Program>& programs) {
  std::set<std::string> groups;
  for (Program& program : programs) {
    attempt(program, [&] {
      for (const std::string& name : program.process.list("")) {
        groups.insert(name.substr(0, name.find('/')));
      }
    });
  }
  std::string known;
  for (const std::string& group : groups) known += (known.empty() ? "" : ", ") + group;
  throw InputError("FILTER: no benchmark matches the regular expression \"" + printable(filter) +
                   "\"; their names begin with " + known);
}

void count_benchmarks(std::vector<Program>& programs, const std::string& filter) {
  bool any = false;
  for (Program& program : programs) {
    attempt(program, [&] {
      if (program.process.list(filter).empty()) return;
      program.count = program.process.list(with_limits(filter)).size();
    });
    any |= program.count > 0 || !program.failure.empty();
  }
  if (!any) refuse(filter, programs);
}

void run_round(std::vector<Program>& programs, const std::string& filter, Progress& progress,
               std::uint64_t done, std::uint64_t total, std::vector<TimedBenchmark>& benchmarks) {
  for (Program& program : programs) {
    if (program.count == 0) continue;
    const std::uint64_t count = program.count;
    attempt(program, [&] {
      const json output = program.process.run(with_limits(filter), [&](std::uint64_t finished) {
        progress.update(done + std::min(finished, count), total);
      });
      program.context = output.value("context", json::object());
      add_round(program.process.name(), output, benchmarks);
      for (const json& one : output.at("benchmarks")) {
        if (!one.value("error_occurred", false)) continue;
        throw std::runtime_error("has a benchmark that failed, " +
                                 one.at("name").get<std::string>() + ": " +
                                 one.value("error_message", ""));
      }
    });
    done += count;
    progress.update(done, total);
  }
}

json described(const Program& program) {
  return {{"name", program.process.name()},
          {"status", program.failure.empty() ? "ok" : "failed"},
          {"message", program.failure},
          {"context", program.context}};
}

/// Checks the output before minutes are spent on measuring.
void require_writable(const fs::path& file) {
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  if (::access(folder.c_str(), W_OK) != 0 || fs::is_directory(file)) {
    throw InputError("--out: " + file.string() +
                     " cannot be written; name a file in a folder that can");
  }
}

}  // namespace

fs::path TimingOptions::benchmark_folder() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "benchmarks";
}

const std::vector<std::string>& benchmark_programs() {
  static const std::vector<std::string> names = {"forward_benchmark",   "dataset_benchmark",
                                                 "solvers_benchmark",   "metrics_benchmark",
                                                 "inference_benchmark", "training_benchmark"};
  return names;
}

int run_timing(const TimingOptions& options) {
  require_writable(options.out);
  const TemporaryFolder temporary("timing");
  std::vector<Program> programs = find_programs(options.programs, temporary.path());
  count_benchmarks(programs, options.filter);

  std::uint64_t count = 0;
  for (const Program& program : programs) count += program.count;
  const auto rounds = static_cast<std::uint64_t>(options.rounds);
  std::vector<TimedBenchmark> benchmarks;
  {
    Progress progress("timing");
    for (std::uint64_t round = 0; round < rounds; ++round) {
      run_round(programs, options.filter, progress, round * count, rounds * count, benchmarks);
    }
  }

  json result = {{"schema", 1},
                 {"provenance", machine_provenance()},
                 {"note", note},
                 {"filter", options.filter},
                 {"rounds", options.rounds},
                 {"programs", json::array()},
                 {"limits", json::array()},
                 {"benchmarks", json::array()}};
  int failed = 0;
  for (const Program& program : programs) {
    result["programs"].push_back(described(program));
    std::vector<json> medians;
    for (const TimedBenchmark& benchmark : benchmarks) {
      if (benchmark.program != program.process.name()) continue;
      medians.push_back(median_of(benchmark));
      result[benchmark.is_limit() ? "limits" : "benchmarks"].push_back(medians.back());
    }
    if (!medians.empty()) {
      Table table;
      table.sections = {timing_table(program.process.name(), medians)};
      std::printf("%s\n", terminal_of(table).c_str());
    }
    if (!program.failure.empty()) {
      ++failed;
      std::printf("%s\n  failed: it %s\n", program.process.name().c_str(),
                  printable(program.failure, 1000).c_str());
    }
  }
  write_file_atomically(options.out, json_text(result, 1) + "\n");
  std::printf("all in %s\n", printable_path(options.out.string()).c_str());
  return failed;
}

}  // namespace ertbench
