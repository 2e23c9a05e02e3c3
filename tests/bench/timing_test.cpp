// The timing command, with shell scripts in place of the benchmark programs.

#include "bench/speed/timing.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/table/table.h"
#include "core/errors.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// As Google Benchmark 1.7.1 writes it, its bare NaN with it.
constexpr const char* output = R"({
  "context": {"library_build_type": "debug", "ertbench_build_type": "release"},
  "benchmarks": [
    {"name": "reconstruct/tsvd/1", "run_name": "reconstruct/tsvd/1", "real_time": 9.0,
     "cpu_time": 4.0, "time_unit": "us", "items_per_second": 2.5e+05, "limit_us": 2.0,
     "of_limit": 5.0e-01, "slope": NaN, "other": -NaN, "far": Infinity, "near": -Infinity,
     "text": "a \"NaN\" stays", "label": "stream"}
  ]
})";

TEST(BenchmarkOutput, BareNanAndInfinityBecomeNull) {
  const json parsed = parse_benchmark_output(output);
  const json& one = parsed.at("benchmarks").at(0);
  for (const char* key : {"slope", "other", "far", "near"}) EXPECT_TRUE(one.at(key).is_null());
  EXPECT_EQ(one.at("text"), "a \"NaN\" stays");
  EXPECT_EQ(one.at("items_per_second"), 2.5e5);
  EXPECT_EQ(parsed.at("context").at("library_build_type"), "debug");
}

TEST(BenchmarkOutput, WhatIsCutOffOrSomethingElseIsRefused) {
  const std::string whole = output;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THROW(parse_benchmark_output(whole.substr(0, length)), std::runtime_error) << length;
  }
  for (const char* other : {"[]", "{}", "1", R"({"benchmarks": {}})", R"({"benchmarks": [1]})",
                            R"({"benchmarks": [{"name": 1}]})"}) {
    EXPECT_THROW(parse_benchmark_output(other), std::runtime_error) << other;
  }
}

json benchmark(const std::string& name, double cpu_time, double real_time = 7) {
  return {{"name", name}, {"cpu_time", cpu_time}, {"real_time", real_time}, {"time_unit", "ms"}};
}

TEST(BenchmarkOutput, MedianOfTheRounds) {
  std::vector<TimedBenchmark> benchmarks;
  for (const double time : {5.0, 1.0, 3.0}) {
    add_round("solvers", {{"benchmarks", {benchmark("a", time), benchmark("b", 2 * time)}}},
              benchmarks);
    add_round("others", {{"benchmarks", {benchmark("a", 10 * time)}}}, benchmarks);
  }
  ASSERT_EQ(benchmarks.size(), 3u);
  EXPECT_EQ(benchmarks[1].name(), "b");
  const json median = median_of(benchmarks[1]);
  EXPECT_EQ(median.at("program"), "solvers");
  EXPECT_EQ(median.at("cpu_time"), 6.0);
  EXPECT_DOUBLE_EQ(median.at("time_s"), 6e-3);
  ASSERT_EQ(median.at("rounds_s").size(), 3u);
  EXPECT_DOUBLE_EQ(median.at("rounds_s")[0], 10e-3);
  EXPECT_DOUBLE_EQ(median_of(benchmarks[2]).at("time_s"), 30e-3);
}

TEST(BenchmarkOutput, ProcessorTimeUnlessWallTimeWasAskedFor) {
  EXPECT_DOUBLE_EQ(seconds_of(benchmark("fit/tsvd", 2)), 2e-3);
  EXPECT_DOUBLE_EQ(seconds_of(benchmark("step/threads:2/real_time", 2)), 7e-3);
  EXPECT_DOUBLE_EQ(seconds_of(benchmark("limit/gemm/iterations:1/manual_time", 2)), 7e-3);
  json failed = benchmark("fit/tsvd", 2);
  failed["cpu_time"] = nullptr;
  EXPECT_TRUE(std::isnan(seconds_of(failed)));
  EXPECT_TRUE(median_of({"p", {failed}}).at("time_s").is_null());
}

TEST(BenchmarkOutput, TableHasTimeRateAndFractionOfTheLimit) {
  std::vector<TimedBenchmark> benchmarks;
  add_round("solvers", parse_benchmark_output(output), benchmarks);
  Table table;
  table.sections = {timing_table("solvers", {median_of(benchmarks.front())})};
  EXPECT_EQ(terminal_of(table),
            "solvers\n"
            "benchmark              time     rate  of the limit\n"
            "reconstruct/tsvd/1  4.00 µs  250 k/s  0.50 of stream\n");
}

/// A folder as a build's: the program, and scripts that look like Google Benchmark to it. Each
/// knows "reconstruct/<script>" and "limit/<script>" and notes its calls in the file `calls`.
class FakeBuild {
 public:
  FakeBuild() : folder_("timing") {
    fs::create_directories(folder_ / "benchmarks");
    copy_program(folder_.path());
    for (const std::string& name : benchmark_programs()) script(name, "");
  }

  /// `instead` is run in place of the benchmarks.
  void script(const std::string& name, const std::string& instead) {
    const std::string text = R"(#!/bin/sh
for argument; do
  case $argument in
    --benchmark_list_tests=true) list=yes ;;
    --benchmark_filter=*) filter=${argument#*=} ;;
    --benchmark_out=*) out=${argument#*=} ;;
  esac
done
names=$(printf '%s\n' reconstruct/NAME limit/NAME | grep -E -e "${filter:-.}")
if [ "$list" ]; then echo "$names"; exit 0; fi
cd "$(dirname "$0")/.."
mkdir running || exit 3  # two at once
echo NAME "$@" >> calls
)" + instead + R"(
{
  echo '{"context": {"library_build_type": "debug"}, "benchmarks": ['
  for name in $names; do
    echo "$comma" '{"name": "'$name'", "run_name": "", "cpu_time": 1.5, "real_time": 3,'
    echo '"time_unit": "ns", "spread": NaN}'
    comma=,
  done
  echo ']}'
} > "$out"
rmdir running
)";
    const fs::path file = folder_ / ("benchmarks/" + name);
    std::string named = text;
    for (auto at = named.find("NAME"); at != std::string::npos; at = named.find("NAME")) {
      named.replace(at, 4, name);
    }
    write_text(file, named);
    fs::permissions(file, fs::perms::owner_all);
  }

  Outcome run(const std::string& arguments) const {
    return run_program(folder_.path(), "timing " + arguments, folder_ / "bench/ertbench");
  }
  json result(const std::string& file = "results/timing.json") const {
    return json::parse(read_text(folder_ / file));
  }
  fs::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
};

TEST(Timing, WritesOneFileWithProvenanceAndLimits) {
  const FakeBuild build;
  const Outcome outcome = build.run("--rounds 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json result = build.result();
  EXPECT_EQ(result.at("schema"), 1);
  for (const char* key : {"commit", "host", "cpu", "libraries", "date"}) {
    EXPECT_TRUE(result.at("provenance").contains(key)) << key;
  }
  EXPECT_NE(result.at("note").get<std::string>().find("debug"), std::string::npos);
  const std::size_t count = benchmark_programs().size();
  for (const char* list : {"programs", "limits", "benchmarks"}) {
    ASSERT_EQ(result.at(list).size(), count) << list;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = benchmark_programs()[i];
    EXPECT_EQ(result["programs"][i]["name"], name);
    EXPECT_EQ(result["programs"][i]["status"], "ok");
    EXPECT_EQ(result["programs"][i]["context"]["library_build_type"], "debug");
    EXPECT_EQ(result["limits"][i]["name"], "limit/" + name);
    const json& one = result["benchmarks"][i];
    EXPECT_EQ(one.at("name"), "reconstruct/" + name);
    EXPECT_EQ(one.at("program"), name);
    EXPECT_DOUBLE_EQ(one.at("time_s"), 1.5e-9);
    EXPECT_EQ(one.at("rounds_s").size(), 2u);
    EXPECT_TRUE(one.at("spread").is_null());
    EXPECT_NE(outcome.output.find("reconstruct/" + name), std::string::npos) << outcome.output;
  }
  // Each once a round, never two at once (a script sees to that), with nothing left behind.
  const std::string calls = read_text(build / "calls");
  EXPECT_EQ(static_cast<std::size_t>(std::count(calls.begin(), calls.end(), '\n')), 2 * count);
  EXPECT_EQ(std::distance(fs::directory_iterator(build / "results"), {}), 1);
}

TEST(Timing, AFilterRunsOnlyWhatMatchesAndTheLimitsBesideIt) {
  const FakeBuild build;
  const Outcome outcome = build.run("'reconstruct/(solvers|inference)' --out here.json --rounds 1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json result = build.result("here.json");
  ASSERT_EQ(result.at("benchmarks").size(), 2u);
  EXPECT_EQ(result["benchmarks"][0]["name"], "reconstruct/solvers_benchmark");
  EXPECT_EQ(result["benchmarks"][1]["name"], "reconstruct/inference_benchmark");
  EXPECT_EQ(result.at("limits").size(), 2u);
  EXPECT_EQ(read_text(build / "calls").find("forward"), std::string::npos);
}

TEST(Timing, AFilterThatMatchesNothingIsRefusedWithTheNames) {
  const FakeBuild build;
  const Outcome outcome = build.run("no_such_benchmark");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  for (const char* part : {"FILTER", "no_such_benchmark", "begin with limit, reconstruct"}) {
    EXPECT_NE(outcome.output.find(part), std::string::npos) << outcome.output;
  }
  EXPECT_FALSE(fs::exists(build / "results/timing.json"));
  EXPECT_FALSE(fs::exists(build / "calls"));
}

TEST(Timing, AMissingProgramIsRefusedWithTheRemedy) {
  const FakeBuild build;
  fs::remove(build / "benchmarks/solvers_benchmark");
  const Outcome outcome = build.run("");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  for (const char* part : {"benchmarks/solvers_benchmark: ", "--target ertbench_benchmarks"}) {
    EXPECT_NE(outcome.output.find(part), std::string::npos) << outcome.output;
  }
}

TEST(Timing, AFailingProgramCostsOnlyItsOwnResults) {
  for (const char* how :
       {"rmdir running; echo out of memory >&2; exit 7", "rmdir running; kill -SEGV $$",
        "rmdir running; echo '{\"benchmarks\": [' > \"$out\"; exit 0"}) {
    SCOPED_TRACE(how);
    FakeBuild build;
    build.script("solvers_benchmark", how);
    const Outcome outcome = build.run("--rounds 1");
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    EXPECT_NE(outcome.output.find("solvers_benchmark"), std::string::npos) << outcome.output;
    const json result = build.result();
    EXPECT_EQ(result.at("benchmarks").size(), benchmark_programs().size() - 1);
    for (const json& program : result.at("programs")) {
      const bool broken = program.at("name") == "solvers_benchmark";
      EXPECT_EQ(program.at("status"), broken ? "failed" : "ok");
      EXPECT_EQ(program.at("message").get<std::string>().empty(), !broken);
    }
  }
}

TEST(Timing, AnOutputThatCannotBeWrittenIsRefusedAtOnce) {
  const FakeBuild build;
  const Outcome outcome = build.run("--out /proc/nowhere/timing.json");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("--out: /proc/nowhere/timing.json"), std::string::npos);
  EXPECT_FALSE(fs::exists(build / "calls"));
}

}  // namespace
}  // namespace ertbench
