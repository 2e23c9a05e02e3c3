// Trainings in bfloat16, and what becomes of them where the processor does not have it.

#include <gtest/gtest.h>

#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

bool processor_has_bfloat16() {
  return read_text("/proc/cpuinfo").find(" avx512_bf16") != std::string::npos;
}

class TrainingPrecision : public ::testing::Test {
 protected:
  TrainingPrecision() {
    json experiment = small_experiment();
    experiment["datasets"]["train"] = {{"count", 600},
                                       {"seed", 1},
                                       {"snr_db", 50},
                                       {"snr_basis", "absolute"},
                                       {"scenes", json::object()}};
    experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}},
                             {{"type", "fcnn"},
                              {"widths", {16, 8, 8}},
                              {"epochs", 1},
                              {"seeds", {1, 2}},
                              {"precision", "bfloat16"}}};
    write_text(folder_ / "e.json", experiment.dump());
  }

  Outcome run(const std::string& options) const {
    return run_program(folder_.path(), "run e.json " + options);
  }

  TemporaryFolder folder_{"precision"};
};

constexpr const char* warning = "e.json: fcnn are trained in bfloat16, for which this processor";

TEST_F(TrainingPrecision, ASlowTrainingIsWarnedOfBeforeItBegins) {
  const Outcome others = run("--only tsvd");
  EXPECT_EQ(others.output.find(warning), std::string::npos) << others.output;
  const Outcome first = run("");
  ASSERT_EQ(first.exit_code, 0) << first.output;
  EXPECT_EQ(first.output.find(warning) == std::string::npos, processor_has_bfloat16())
      << first.output;
  const Outcome second = run("");  // the cache has it
  EXPECT_EQ(second.output.find(warning), std::string::npos) << second.output;
}

TEST_F(TrainingPrecision, Float32IsAnotherFitThatTheResultTellsOf) {
  ASSERT_EQ(run("").exit_code, 0);
  const Outcome outcome = run("--precision float32 --out results/f");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find(warning), std::string::npos) << outcome.output;
  const json summary = summary_of(folder_ / "results/f");
  EXPECT_EQ(row_of(summary, "fcnn").at("parameters").at("precision"), "float32");
  EXPECT_EQ(summary.at("set"), json({"/solvers/1/precision=float32"}));
  EXPECT_EQ(summary.at("command"), "./ertbench run e.json --precision float32 --out results/f");
  const json in_bfloat16 = summary_of(folder_ / "results/e");
  EXPECT_NE(row_of(summary, "fcnn").at("metrics"), row_of(in_bfloat16, "fcnn").at("metrics"));
  EXPECT_EQ(row_of(summary, "tsvd").at("metrics"), row_of(in_bfloat16, "tsvd").at("metrics"));
}

}  // namespace
}  // namespace ertbench
