#include "bench/timing/benchmark_process.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "bench/timing/benchmark_output.h"
#include "core/process.h"
#include "core/progress.h"
#include "core/regular_file.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

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
  const std::string text = contents_of(file);
  std::uint64_t count = 0;
  for (auto at = text.find("\"run_name\""); at != std::string::npos;
       at = text.find("\"run_name\"", at + 1)) {
    ++count;
  }
  return count;
}

}  // namespace

BenchmarkProcess::BenchmarkProcess(fs::path program, fs::path folder)
    : program_(std::move(program)), folder_(std::move(folder)) {}

std::vector<std::string> BenchmarkProcess::list(const std::string& filter) const {
  std::vector<std::string> arguments = {program_, "--benchmark_list_tests=true"};
  if (!filter.empty()) arguments.push_back("--benchmark_filter=" + filter);
  require_success(
      ChildProcess(arguments, {folder_ / "log", folder_ / "names"}, {time_limit_s}).wait(),
      folder_ / "log");
  std::vector<std::string> names;
  std::ifstream in(folder_ / "names");
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) names.push_back(line);
  }
  return names;
}

nlohmann::json BenchmarkProcess::run(const std::string& filter,
                                     const std::function<void(std::uint64_t)>& finished) const {
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

}  // namespace ertbench
