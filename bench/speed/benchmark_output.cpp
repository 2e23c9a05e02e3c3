#include "bench/speed/benchmark_output.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/process.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

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

/// "3.90 µs"
std::string seconds_text(double seconds) {
  if (seconds < 1e-6) return three_digits(1e9 * seconds) + " ns";
  if (seconds < 1e-3) return three_digits(1e6 * seconds) + " µs";
  return seconds < 1 ? three_digits(1e3 * seconds) + " ms" : three_digits(seconds) + " s";
}

/// "256 k", "40.7 G"
std::string items_text(double rate) {
  if (rate < 1e3) return three_digits(rate) + " ";
  if (rate < 1e6) return three_digits(1e-3 * rate) + " k";
  return rate < 1e9 ? three_digits(1e-6 * rate) + " M" : three_digits(1e-9 * rate) + " G";
}

std::string rate_of(const json& benchmark) {
  for (const auto& [key, unit] :
       {std::pair{"FLOP/s", "FLOP/s"}, std::pair{"items_per_second", "/s"},
        std::pair{"bytes_per_second", "B/s"}}) {
    const auto rate = benchmark.find(key);
    if (rate != benchmark.end() && rate->is_number()) return items_text(*rate) + unit;
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
      !std::all_of(benchmarks->begin(), benchmarks->end(), is_benchmark)) {
    throw std::runtime_error("its output has no list \"benchmarks\" of objects with a \"name\"");
  }
  return output;
}

void add_round(const std::string& program, const json& output,
               std::vector<TimedBenchmark>& benchmarks) {
  for (const json& one : output.at("benchmarks")) {
    const std::string name = one.at("name");
    const auto known = std::find_if(
        benchmarks.begin(), benchmarks.end(),
        [&](const TimedBenchmark& b) { return b.program == program && b.name() == name; });
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
    std::sort(rounds.begin(), rounds.end());
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
                            time.is_number() ? seconds_text(time) : "—", rate_of(one),
                            limit_of(one)});
  }
  return section;
}

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
