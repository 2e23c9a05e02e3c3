#include "bench/speed/timing.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <stdexcept>
#include <thread>

#include "bench/record/record_file.h"
#include "bench/speed/speed_accuracy.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// `text` with null in place of NaN and Infinity, signed or not, outside of strings.
std::string with_nulls(std::string_view text) {
  std::string out;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (!in_string) {
      const std::size_t sign = text[i] == '-' || text[i] == '+' ? 1 : 0;
      std::size_t length = 0;
      for (const std::string_view word : {"NaN", "nan", "Infinity", "inf"}) {
        if (text.substr(i + sign).starts_with(word)) length = std::max(length, word.size());
      }
      if (length > 0) {
        out += "null";
        i += sign + length - 1;
        continue;
      }
    }
    if (text[i] == '"') in_string = !in_string;
    out += text[i];
    if (in_string && text[i] == '\\' && i + 1 < text.size()) out += text[++i];
  }
  return out;
}

double unit_seconds(const std::string& unit) {
  if (unit == "ns") return 1e-9;
  if (unit == "us") return 1e-6;
  return unit == "ms" ? 1e-3 : 1;
}

std::string rate_of(const json& benchmark) {
  for (const auto& [key, unit] :
       {std::pair{"FLOP/s", "FLOP/s"}, std::pair{"items_per_second", "/s"},
        std::pair{"bytes_per_second", "B/s"}}) {
    const auto rate = benchmark.find(key);
    if (rate != benchmark.end() && rate->is_number()) return rate_text(*rate) + unit;
  }
  return "";
}

std::string limit_of(const json& benchmark) {
  if (benchmark.value("error_occurred", false)) {
    return "failed: " + one_line(benchmark.value("error_message", "without a message"), 60);
  }
  const auto fraction = benchmark.find("of_limit");
  if (fraction == benchmark.end() || !fraction->is_number()) return "";
  return fixed(*fraction, 2) + " of " + benchmark.value("label", "");
}

constexpr double time_limit_s = 3600;
constexpr const char* least_time = "--benchmark_min_time=0.2";  ///< of one benchmark, s
constexpr std::size_t longest_message = 300;

void require_success(const ProcessEnd& end, const fs::path& log) {
  if (end.ok()) return;
  std::string how = "ended with exit code " + std::to_string(end.exit_code);
  if (end.signal) how = "was ended by a signal: " + std::string(::strsignal(end.signal));
  if (end.timed_out) how = "ran longer than " + duration_text(time_limit_s);
  const std::string said = contents_of(log);
  const std::size_t length = std::min(said.size(), longest_message);
  const std::string last = one_line(said.substr(said.size() - length), longest_message);
  throw std::runtime_error(last.empty() ? how : how + ": " + last);
}

/// Google Benchmark adds each benchmark to its file when that has run.
std::uint64_t benchmarks_in(const fs::path& file) {
  return split(contents_of(file), "\"run_name\"").size() - 1;
}

/// A Google Benchmark program, run as a child process. If it fails, the functions throw
/// std::runtime_error with how it ended and its last output.
class BenchmarkProcess {
 public:
  /// `folder` is for temporary files and must outlive this.
  BenchmarkProcess(fs::path program, fs::path folder)
      : program_(std::move(program)), folder_(std::move(folder)) {}

  std::string name() const { return program_.filename(); }

  /// The names of its benchmarks that match `filter`, as --benchmark_filter; empty: all.
  std::vector<std::string> list(const std::string& filter) const {
    std::vector<std::string> arguments = {program_, "--benchmark_list_tests=true"};
    if (!filter.empty()) arguments.push_back("--benchmark_filter=" + filter);
    require_success(
        ChildProcess(arguments, {folder_ / "log", folder_ / "names"}, {time_limit_s}).wait(),
        folder_ / "log");
    std::vector<std::string> names = split(contents_of(folder_ / "names"), "\n");
    std::erase(names, "");
    return names;
  }

  /// Runs them and returns the parsed output (parse_benchmark_output). `finished` is called a few
  /// times a second with the number of benchmarks done.
  json run(const std::string& filter, const std::function<void(std::uint64_t)>& finished) const {
    const fs::path out = folder_ / "output.json";
    fs::remove(out);
    std::vector<std::string> arguments = {program_, "--benchmark_out=" + out.string(),
                                          "--benchmark_out_format=json", least_time};
    if (!filter.empty()) arguments.push_back("--benchmark_filter=" + filter);
    ChildProcess process(arguments, {folder_ / "log"}, {time_limit_s});
    while (!process.poll()) {
      finished(benchmarks_in(out));
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    require_success(process.wait(), folder_ / "log");
    return parse_benchmark_output(contents_of(out));
  }

 private:
  fs::path program_;
  fs::path folder_;
};

constexpr const char* note =
    "time_s is the median of rounds_s: processor time, but wall time where the name says "
    "real_time. limit_us is the least time that the machine allows by what \"label\" names, "
    "of_limit that over the measured time. library_build_type \"debug\" is how Debian built Google "
    "Benchmark 1.7.1; how ertbench was built is ertbench_build_type. NaN, which that version "
    "writes bare, is null here.";

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
  throw InputError("FILTER: no benchmark matches the regular expression \"" + printable(filter) +
                   "\"; their names begin with " + joined(groups));
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

json parse_benchmark_output(std::string_view text) {
  json output;
  try {
    output = parse_json(with_nulls(text), "its output");
  } catch (const InputError& error) {
    throw std::runtime_error(error.what());
  }
  const auto benchmarks = output.find("benchmarks");
  const auto is_benchmark = [](const json& one) {
    return one.is_object() && one.contains("name") && one["name"].is_string();
  };
  if (benchmarks == output.end() || !benchmarks->is_array() ||
      !std::ranges::all_of(*benchmarks, is_benchmark)) {
    throw std::runtime_error("its output has no list \"benchmarks\" of objects with a \"name\"");
  }
  return output;
}

void add_round(const std::string& program, const json& output,
               std::vector<TimedBenchmark>& benchmarks) {
  for (const json& one : output.at("benchmarks")) {
    const std::string name = one.at("name");
    const auto known = std::ranges::find_if(benchmarks, [&](const TimedBenchmark& b) {
      return b.program == program && b.name() == name;
    });
    if (known == benchmarks.end()) {
      benchmarks.push_back({program, {one}});
    } else {
      known->rounds.push_back(one);
    }
  }
}

double seconds_of(const json& benchmark) {
  const std::string name = benchmark.at("name");
  const bool wall = name.find("/real_time") != std::string::npos ||
                    name.find("/manual_time") != std::string::npos;
  const auto time = benchmark.find(wall ? "real_time" : "cpu_time");
  if (time == benchmark.end() || !time->is_number()) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return time->get<double>() * unit_seconds(benchmark.value("time_unit", "ns"));
}

json median_of(const TimedBenchmark& benchmark) {
  std::vector<std::pair<double, const json*>> rounds;
  json times = json::array();
  for (const json& round : benchmark.rounds) {
    const double seconds = seconds_of(round);
    times.push_back(std::isfinite(seconds) ? json(seconds) : json());
    if (std::isfinite(seconds)) rounds.emplace_back(seconds, &round);
  }
  json out = benchmark.rounds.front();
  if (!rounds.empty()) {
    std::ranges::sort(rounds);
    out = *rounds[nearest_rank(rounds.size(), 0.5)].second;
  }
  out["program"] = benchmark.program;
  out["time_s"] = rounds.empty() ? json() : json(seconds_of(out));
  const std::string name = benchmark.name();
  out["name"] = name.substr(0, name.find("/iterations:"));  // said again under "iterations"
  out["rounds_s"] = times;
  return out;
}

TableSection timing_table(const std::string& program, const std::vector<json>& medians) {
  TableSection section;
  section.caption = program;
  section.columns = {{"benchmark", Align::left}, "time", "rate", {"of the limit", Align::left}};
  for (const json& one : medians) {
    const json& time = one.at("time_s");
    section.rows.push_back({one.at("name").get<std::string>(),
                            time.is_number() ? time_text(1e6 * time.get<double>()) : "—",
                            rate_of(one), limit_of(one)});
  }
  return section;
}

fs::path TimingOptions::benchmark_folder() {
  return fs::read_symlink("/proc/self/exe").parent_path().parent_path() / "benchmarks";
}

const std::vector<std::string>& benchmark_programs() {
  static const std::vector<std::string> names = {"forward_benchmark", "solvers_benchmark",
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
      const TableSection table = timing_table(program.process.name(), medians);
      std::printf("%s\n", terminal_of({"", "", {table}, {}, ""}).c_str());
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
