// Programs of other languages as solvers, as a user runs them: the examples, and what happens to a
// row whose program does not keep to the protocol.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

const fs::path examples = fs::path(ERTBENCH_SOURCE_DIR) / "examples";

/// Whether the system's own Python, to which Debian's packages belong, has the modules; it is the
/// `python3` of everything from then on.
bool python_has(const std::string& modules) {
  static const bool is_first = [] {
    const char* const path = std::getenv("PATH");
    return setenv("PATH", (std::string("/usr/bin:") + (path ? path : "")).c_str(), 1) == 0;
  }();
  return is_first &&
         std::system(("python3 -c 'import " + modules + "' >/dev/null 2>&1").c_str()) == 0;
}

/// An example's experiment beside its programs in a folder of its own, on fewer frames.
json example_in(const TemporaryFolder& folder, const std::string& name) {
  fs::copy(examples, folder.path(), fs::copy_options::recursive);
  json experiment = json::parse(read_text(examples / "numpy_ridge.json"));
  experiment.merge_patch(json::parse(read_text(examples / (name + ".json"))));
  experiment.erase("$schema");
  experiment.erase("extends");
  experiment["datasets"]["train"]["count"] = 800;
  experiment["datasets"]["test"]["count"] = 60;
  experiment["timing"] = {{"frames", 662}, {"rounds", 2}, {"batch", 64}};
  experiment["figure"] = {{"scenes", {0}}};
  return experiment;
}

json run_experiment(const TemporaryFolder& folder, const json& experiment, int exit_code = 0) {
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json --jobs 1");
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.output;
  return summary_of(folder / "results/small");
}

int fitted_programs(const TemporaryFolder& folder) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(folder / "cache/solvers")) {
    count += entry.path().filename().string().starts_with("command-") &&
             entry.path().extension() == ".fitted";
  }
  return count;
}

TEST(CommandProgram, OfNumPyIsARowWithItsPipeBesideItsTime) {
  if (!python_has("numpy, h5py")) GTEST_SKIP() << "needs python3-numpy and python3-h5py";
  const TemporaryFolder folder("ridge");
  const json experiment = example_in(folder, "numpy_ridge");
  const json summary = run_experiment(folder, experiment);
  const json& row = row_of(summary, "numpy ridge");
  EXPECT_EQ(row.at("status"), "ok") << row.at("message");
  const auto error = [&](const char* label) {
    return row_of(summary, label).at("metrics").at("relative_error").at("mean").get<double>();
  };
  // It has learned what the linearised method knows: an image of zero has the error 1.
  EXPECT_LT(error("numpy ridge"), 0.95);
  EXPECT_LT(error("numpy ridge"), 1.1 * error("one-step-gn"));
  EXPECT_GT(row.at("latency_us").at("pipe").get<double>(), 1);  // two changes of process
  EXPECT_FALSE(row_of(summary, "one-step-gn").at("latency_us").contains("pipe"));
  const std::string table = read_text(folder / "results/small/table.md");
  EXPECT_NE(table.find("pipe (µs)"), std::string::npos) << table;

  // What is in the program's file is part of the fit.
  EXPECT_EQ(fitted_programs(folder), 1);
  run_experiment(folder, experiment);
  EXPECT_EQ(fitted_programs(folder), 1);
  write_text(folder / "numpy_ridge.py", read_text(folder / "numpy_ridge.py") + "# changed\n");
  run_experiment(folder, experiment);
  EXPECT_EQ(fitted_programs(folder), 2);
}

TEST(CommandProgram, OfPyTorchIsTrainedOnce) {
  if (!python_has("numpy, h5py, torch")) GTEST_SKIP() << "needs python3-torch and python3-h5py";
  const TemporaryFolder folder("eager");
  json experiment = example_in(folder, "torch_eager");
  experiment["solvers"][1]["parameters"]["epochs"] = 15;
  const json summary = run_experiment(folder, experiment);
  const json& row = row_of(summary, "torch eager");
  EXPECT_EQ(row.at("status"), "ok") << row.at("message");
  EXPECT_LT(row.at("metrics").at("relative_error").at("mean").get<double>(), 1);
  const std::string trained = read_text(folder / "results/small/records/torch eager.accuracy.log");
  EXPECT_NE(trained.find("epoch 15 of 15"), std::string::npos) << trained;
  for (const auto& entry : fs::directory_iterator(folder / "results/small/records")) {
    const std::string name = entry.path().filename().string();
    if (name.find("timing") == std::string::npos || entry.path().extension() != ".log") continue;
    EXPECT_EQ(read_text(entry.path()).find("epoch"), std::string::npos) << name;
  }
}

TEST(CommandProgram, OfOthersIsARowOrSaysWhereTheyAre) {
  const TemporaryFolder folder("peers");
  json experiment = small_experiment();
  const std::string peers = (examples / "peers").string();
  experiment["solvers"] = {
      {{"type", "tsvd"}, {"rank", 30}},
      {{"type", "command"},
       {"label", "pyEIT"},
       {"command", {"python3", peers + "/pyeit_child.py"}},
       {"parameters", {{"method", "jac"}, {"lamb", 10}}}},
      {{"type", "command"},
       {"label", "EIDORS"},
       {"command", {"octave-cli", "--norc", "--no-history", "--quiet", peers + "/eidors_child.m"}},
       {"parameters", {{"hyperparameter", 0.5}}}}};
  write_text(folder / "small.json", experiment.dump());
  run_program(folder.path(), "run small.json --jobs 1");
  const json summary = summary_of(folder / "results/small");
  const double error =
      row_of(summary, "tsvd").at("metrics").at("relative_error").at("mean").get<double>();
  for (const char* label : {"pyEIT", "EIDORS"}) {
    const json& row = row_of(summary, label);
    const std::string message = row.at("message");
    if (row.at("status") == "ok") {
      // Linear methods with the same model and a regularisation of the right size.
      const double other = row.at("metrics").at("relative_error").at("mean");
      EXPECT_LT(std::abs(other - error), 0.25 * error) << label;
      continue;
    }
    EXPECT_EQ(row.at("status"), "failed") << label;
    const bool says = message.find("get.sh") != std::string::npos ||
                      message.find("cannot be started") != std::string::npos;
    EXPECT_TRUE(says) << label << ": " << message;
  }
}

TEST(CommandProgram, CostsItsRowAloneWhereItFails) {
  const TemporaryFolder folder("fails");
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}};
  for (const char* mode : {"raise", "crash", "hang", "chat", "nan"}) {
    experiment["solvers"].push_back(
        {{"type", "command"},
         {"label", mode},
         {"command", {"python3", ERTBENCH_TEST_DATA "/programs/child.py", mode}},
         {"frame_limit_s", 0.05}});
  }
  const json summary = run_experiment(folder, experiment, 1);
  const auto status = [&](const char* label) { return row_of(summary, label).at("status"); };
  const auto message = [&](const char* label) {
    return row_of(summary, label).at("message").get<std::string>();
  };
  EXPECT_EQ(status("tsvd"), "ok");
  EXPECT_EQ(status("raise"), "failed");
  EXPECT_NE(message("raise").find("ValueError: no sheet without electrodes"), std::string::npos)
      << message("raise");
  EXPECT_EQ(status("crash"), "crashed");
  EXPECT_NE(message("crash").find("Segmentation fault"), std::string::npos) << message("crash");
  EXPECT_EQ(status("hang"), "timed out");
  EXPECT_EQ(status("chat"), "failed");
  EXPECT_EQ(status("nan"), "ok");
  EXPECT_GT(row_of(summary, "nan").at("undefined_frames").get<int>(), 0);
  const std::string log = read_text(folder / "results/small/records/raise.accuracy.log");
  EXPECT_NE(log.find("Traceback"), std::string::npos) << log;
}

TEST(CommandProgram, IsRefusedWhereItIsNotThere) {
  const TemporaryFolder folder("absent");
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "command"}, {"command", {"./absent"}}}};
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run small.json");
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_NE(outcome.output.find("small.json: /solvers/0/command: ./absent is no program in"),
            std::string::npos)
      << outcome.output;
}

/// The page's program is the example's, so that what it shows is what is tested.
TEST(CommandProgram, OnThePageIsTheExample) {
  const std::string page = read_text(fs::path(ERTBENCH_SOURCE_DIR) / "docs/your_method.md");
  EXPECT_NE(page.find("```python\n" + read_text(examples / "numpy_ridge.py") + "```"),
            std::string::npos);
  const json row = json::parse(read_text(examples / "numpy_ridge.json")).at("solvers").at(1);
  const std::size_t shown = page.find("```js\n") + 6;
  EXPECT_EQ(json::parse(page.substr(shown, page.find('\n', shown) - shown)), row);
}

}  // namespace
}  // namespace ertbench
