// The program as users call it: exit codes, messages, interrupted and repeated runs.

#include "tests/bench/program.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// What must not depend on how a run went: everything but the clocks and the date.
json lasting_part(json summary) {
  for (json& row : summary.at("rows")) {
    for (const char* key : {"fit_s", "latency_us", "frames_per_s", "peak_rss_mb", "timed_on"}) {
      row.erase(key);
    }
  }
  return summary.at("rows");
}

TEST(Program, RunWritesEveryResult) {
  const TemporaryFolder folder("run");
  json experiment = small_experiment();
  experiment["timing"] = {{"frames", 662}, {"batch", 8}};
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("one-step-gn"), std::string::npos);
  const fs::path results = folder / "results/small";
  for (const char* file : {"summary.json", "table.md", "table.csv", "table.tex", "report.html",
                           "reconstructions.svg", "reconstructions.png"}) {
    EXPECT_GT(fs::file_size(results / file), 500u) << file;
  }
  const json summary = summary_of(results);
  EXPECT_EQ(summary.at("schema"), 1);
  EXPECT_EQ(summary.at("experiment"), "small");
  for (const char* key : {"commit", "host", "cpu", "threads", "libraries", "date", "seeds"}) {
    EXPECT_TRUE(summary.at("provenance").contains(key)) << key;
  }
  EXPECT_EQ(summary.at("rows").size(), 5u);
  EXPECT_EQ(row_of(summary, "no-contact").at("metrics").at("AR").at("mean"), 0);
  EXPECT_EQ(row_of(summary, "no-contact").at("metrics").at("RES").at("undefined"), 40);
  EXPECT_EQ(row_of(summary, "truth").at("metrics").at("RIE").at("mean"), 0);
  for (const char* label : {"one-step-gn", "tsvd", "pdipm"}) {
    const json& row = row_of(summary, label);
    EXPECT_EQ(row.at("status"), "ok");
    EXPECT_EQ(row.at("frames"), 40);
    // Better than doing nothing, by far more than the interval.
    EXPECT_LT(row.at("metrics").at("relative_error").at("ci95")[1], 0.95);
    const json& latency = row.at("latency_us");
    EXPECT_GT(latency.at("p50"), 0);
    EXPECT_LE(latency.at("p50"), latency.at("p99"));
    EXPECT_LE(latency.at("p99"), latency.at("max"));
    EXPECT_GT(latency.at("contacts_p50"), 0);
    EXPECT_LE(latency.at("contacts_p50"), latency.at("contacts_p99"));
    EXPECT_GT(row.at("frames_per_s"), 0);
    EXPECT_GT(row.at("peak_rss_mb"), 0);
  }
  const json& parameters = row_of(summary, "one-step-gn").at("parameters");
  EXPECT_TRUE(parameters.at("lambda").is_number());
  EXPECT_TRUE(parameters.at("contacts").at("threshold").is_number());
  EXPECT_TRUE(parameters.at("contacts").at("floor").is_number());
}

TEST(Program, OneOrTwoJobsGiveTheSame) {
  const TemporaryFolder folder("jobs");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json --jobs 1 --out one").exit_code, 0);
  fs::remove_all(folder / "cache");
  ASSERT_EQ(run_program(folder.path(), "run small.json --jobs 2 --out two").exit_code, 0);
  EXPECT_EQ(lasting_part(summary_of(folder / "one")), lasting_part(summary_of(folder / "two")));
}

TEST(Program, RepeatedRunComputesNothingTwice) {
  const TemporaryFolder folder("repeat");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json").exit_code, 0);
  const auto ages = [&] {
    std::map<std::string, fs::file_time_type> out;
    for (const char* part : {"cache", "results/small/records"}) {
      for (const auto& entry : fs::recursive_directory_iterator(folder / part)) {
        if (entry.is_regular_file()) out[entry.path()] = entry.last_write_time();
      }
    }
    return out;
  };
  const auto before = ages();
  const json first = summary_of(folder / "results/small");
  ASSERT_EQ(run_program(folder.path(), "run small.json").exit_code, 0);
  EXPECT_EQ(ages(), before);
  EXPECT_EQ(lasting_part(summary_of(folder / "results/small")), lasting_part(first));
  ASSERT_EQ(run_program(folder.path(), "run small.json --fresh --only tsvd").exit_code, 0);
  EXPECT_NE(ages(), before);
  EXPECT_EQ(lasting_part(summary_of(folder / "results/small")), lasting_part(first));
}

TEST(Program, KilledAtRandomTimesAndRepeated) {
  const TemporaryFolder folder("kill");
  json experiment = small_experiment();
  experiment["datasets"]["validation"]["count"] = 3000;
  write_text(folder / "small.json", experiment.dump());
  ASSERT_EQ(run_program(folder.path(), "run small.json --out whole").exit_code, 0);
  fs::remove_all(folder / "cache");
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  for (int attempt = 0; attempt < 8; ++attempt) {
    const pid_t child = ::fork();
    if (child == 0) {
      ::setpgid(0, 0);
      _exit(run_program(folder.path(), "run small.json --out killed").exit_code);
    }
    ::setpgid(child, child);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + random() % 700));
    ::kill(-child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    // Whatever is there under its final name is whole.
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
      if (entry.path().extension() == ".json") {
        EXPECT_TRUE(json::accept(read_text(entry.path()))) << entry.path();
      }
      if (entry.path().extension() == ".h5") {
        EXPECT_NO_THROW(DatasetFile{entry.path()});
      }
    }
  }
  // Trials die with the run; give the last one the moment it needs.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const Outcome outcome = run_program(folder.path(), "run small.json --out killed");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(lasting_part(summary_of(folder / "killed")),
            lasting_part(summary_of(folder / "whole")));
}

TEST(Program, FailingTrialsCostOnlyTheirRows) {
  const TemporaryFolder folder("fail");
  json experiment = small_experiment();
  experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
#ifdef __SANITIZE_ADDRESS__
  experiment["time_limit_s"] = 60;
#else
  experiment["time_limit_s"] = 8;
#endif
  experiment["solvers"] = json::array({{{"type", "tsvd"}, {"rank", 30}}});
  for (const char* how : {"crash", "throw", "hang", "nan", "stops"}) {
    experiment["solvers"].push_back({{"type", "misbehaving"}, {"how", how}, {"label", how}});
  }
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json --jobs 2");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  const json summary = summary_of(folder / "results/small");
  const auto status = [&](const char* label) { return row_of(summary, label).at("status"); };
  EXPECT_EQ(status("tsvd"), "ok");
  EXPECT_EQ(status("crash"), "crashed");
  EXPECT_EQ(status("throw"), "failed");
  EXPECT_NE(row_of(summary, "throw").at("message").get<std::string>().find("on fire"),
            std::string::npos);
  EXPECT_EQ(status("hang"), "timed out");
  EXPECT_EQ(status("nan"), "ok");
  EXPECT_EQ(row_of(summary, "nan").at("undefined_frames"), 20);
  EXPECT_EQ(row_of(summary, "stops").at("frames_not_converged"), 40);
  const std::string table = read_text(folder / "results/small/table.md");
  for (const char* label : {"crash", "throw", "hang", "nan", "stops"}) {
    EXPECT_NE(table.find(label), std::string::npos) << label;
  }
}

TEST(Program, AnAbsentOrBrokenPluginCostsOnlyItsSolvers) {
  const TemporaryFolder folder("plugin");
  const fs::path program = copy_program(folder.path());  // has no plugin beside it
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}, {{"type", "dd-ert"}}};
  write_text(folder / "small.json", experiment.dump());
  write_text(folder / "learned.json", R"({"type": "dd-ert", "checkpoint": "net.fitted"})");
  write_text(folder / "net.fitted", "read by the plugin alone");
  ASSERT_EQ(run_program(folder.path(), "generate small.json --dataset test --out t.h5", program)
                .exit_code,
            0);
  for (const bool broken : {false, true}) {
    SCOPED_TRACE(broken ? "broken" : "absent");
    if (broken) write_text(folder / "bench/libertbench_models.so", "no library");
    const Outcome outcome = run_program(folder.path(), "run small.json --fresh", program);
    EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
    const json summary = summary_of(folder / "results/small");
    EXPECT_EQ(row_of(summary, "tsvd").at("status"), "ok");
    EXPECT_EQ(row_of(summary, "dd-ert").at("status"), "failed");
    const std::string message = row_of(summary, "dd-ert").at("message");
    EXPECT_NE(message.find("libertbench_models.so"), std::string::npos) << message;
    const Outcome frames = run_program(
        folder.path(), "reconstruct --solver learned.json --input t.h5 --output o.h5", program);
    EXPECT_EQ(frames.exit_code, 2);
    EXPECT_NE(frames.output.find("libertbench_models.so"), std::string::npos) << frames.output;
  }
}

TEST(Program, ReadmesSolverAndExperimentWork) {
  const TemporaryFolder folder("readme");
  json experiment = json::parse(read_text(ERTBENCH_PAGE_EXPERIMENT));
  experiment["plugins"] = {ERTBENCH_PAGE_PLUGIN};
  experiment["solvers"].push_back({{"type", "back-projection"}, {"gain", 0.05}});
  experiment["datasets"]["validation"]["count"] = 20;
  experiment["datasets"]["test"]["count"] = 20;
  experiment["timing"] = {{"enabled", false}};
  write_text(folder / "readme.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run readme.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "results/readme");
  for (const char* label : {"one-step-gn", "tsvd", "pdipm", "back-projection"}) {
    EXPECT_EQ(row_of(summary, label).at("status"), "ok");
  }
  // It smears, but it points at the contacts.
  EXPECT_LT(row_of(summary, "back-projection").at("metrics").at("relative_error").at("mean"), 1);
}

TEST(Program, HelpShowsAnExampleOfEachCommand) {
  const TemporaryFolder folder("help");
  for (const std::string command :
       {"run", "check", "generate", "reconstruct", "list", "timing", "fidelity"}) {
    const Outcome outcome = run_program(folder.path(), command + " --help");
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_NE(outcome.output.find("ertbench " + command), std::string::npos) << outcome.output;
  }
  const Outcome list = run_program(folder.path(), "list");
  EXPECT_EQ(list.exit_code, 0);
  for (const char* name : {"one-step-gn", "tsvd", "pdipm", "fcnn", "dcnn", "eit-nn", "dd-ert",
                           "lean-net", "lambda", "table_c1.json"}) {
    EXPECT_NE(list.output.find(name), std::string::npos) << name;
  }
}

}  // namespace
}  // namespace ertbench
