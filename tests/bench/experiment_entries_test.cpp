// What entries of "solvers" become: labels, seeds, sweeps, families.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "bench/speed/speed_chart.h"
#include "solvers/registry/registry.h"
#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

TEST(Experiment, ASolverThatIsTrainedNeedsItsDatasets) {
  const TemporaryFolder folder("untrained");
  json value = learned({{"how", "needs data"}});
  value["datasets"].erase("train");
  write_text(folder / "e.json", value.dump());
  const std::string message = refusal(folder / "e.json");
  EXPECT_NE(message.find("/solvers/0/type: toy-learned is trained; add /datasets/train"),
            std::string::npos)
      << message;
}

TEST(Experiment, SeedsAndSweepsBecomeTrials) {
  const TemporaryFolder folder("trials");
  const json value = learned(
      {{"seeds", {3, 1}}, {"sweep", {{"level", {-1e-4, -0.125}}, {"how", {"crash", "diverge"}}}}});
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
  std::vector<std::string> stems;
  for (const SolverEntry& entry : e.solvers) stems.push_back(entry.stem());
  EXPECT_EQ(stems, (std::vector<std::string>{
                       "net how=crash level=-0.0001.seed3", "net how=crash level=-0.0001.seed1",
                       "net how=crash level=-0.125.seed3", "net how=crash level=-0.125.seed1",
                       "net how=diverge level=-0.0001.seed3", "net how=diverge level=-0.0001.seed1",
                       "net how=diverge level=-0.125.seed3", "net how=diverge level=-0.125.seed1",
                       "one-step-gn", "pdipm"}));
  EXPECT_EQ(e.rows().size(), 6u);
  EXPECT_EQ(e.rows()[1].size(), 2u);
  EXPECT_EQ(*e.solvers[2].spec, json::parse(R"({"type": "toy-learned", "label": "net",
      "how": "crash", "level": -0.125, "seed": 3})"));
  EXPECT_EQ(*e.solvers[2].sweep, json({{"how", "crash"}, {"level", -0.125}}));
}

TEST(Experiment, SeedsOfOthersStandInNamesOfFiles) {
  const TemporaryFolder folder("others");
  json value = good();
  value["solvers"] = json::parse(R"([
      {"type": "torchscript", "file": "model-{seed}.pt", "seeds": [1, 12]},
      {"type": "command", "command": ["python3", "net.py", "{seed}-{seed}", "{"], "protocol": 2,
       "seeds": [3]}])");
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e =
      read_experiment(folder / "e.json", registry, chart_types(), SolverCheck::none);
  ASSERT_EQ(e.solvers.size(), 3u);
  EXPECT_EQ(e.rows().size(), 2u);
  EXPECT_EQ(e.solvers[2].spec->at("command"), json({"python3", "net.py", "3-3", "{"}));
  EXPECT_EQ(e.solvers[2].spec->at("seed"), 3);
  EXPECT_EQ(e.solvers[1].spec->at("file"), "model-12.pt");
}

TEST(Experiment, FamiliesAndSweptListsMakeTheirRows) {
  const TemporaryFolder folder("families");
  json value = good();
  value["solvers"] = json::parse(R"([
      {"type": "tsvd", "family": "linear", "sweep": {"rank": [10, 20]}},
      {"type": "one-step-gn", "family": "linear", "lambda": 1},
      {"type": "fcnn", "sweep": {"widths": [[16, 8], [32]]}}])");
  value["right_sizing"] = json::object();
  value["charts"] = json::parse(R"([
      {"type": "speed-accuracy", "name": "all"},
      {"type": "speed-accuracy", "name": "linear", "solvers": ["linear"], "metric": "PE"}])");
  value["charts"][0]["budgets_us"] = {50};
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e =
      read_experiment(folder / "e.json", registry, chart_types(), SolverCheck::none);
  ASSERT_EQ(e.solvers.size(), 5u);
  EXPECT_EQ(e.solvers[1].family, "linear");
  EXPECT_EQ(e.solvers[1].label, "tsvd rank=20");
  EXPECT_EQ(e.solvers[2].family, "linear");
  EXPECT_FALSE(e.solvers[2].spec->contains("family"));
  EXPECT_EQ(e.solvers[3].label, "fcnn widths=16-8");
  EXPECT_EQ(e.solvers[3].spec->at("widths"), json({16, 8}));
  const SpeedQuestion& all = dynamic_cast<const SpeedChart&>(*e.charts.at(0)).question();
  EXPECT_EQ(all.break_even_against, std::vector<std::string>{"one-step-gn"});
  EXPECT_EQ(all.budgets_us, std::vector<double>{50});
  const SpeedQuestion& linear = dynamic_cast<const SpeedChart&>(*e.charts.at(1)).question();
  EXPECT_EQ(linear.labels,
            (std::vector<std::string>{"tsvd rank=10", "tsvd rank=20", "one-step-gn"}));
  EXPECT_EQ(linear.metric, Metric::PE);
}

TEST(Experiment, SeedsThatCannotBeAreRefused) {
  const TemporaryFolder folder("seeds_refused");
  const std::tuple<json, const char*, const char*> cases[] = {
      {{{"seeds", json::array()}}, "/solvers/0/seeds", "1 to 100"},
      {{{"seeds", 3}}, "/solvers/0/seeds", "list"},
      {{{"seeds", {1, 2, 1}}}, "/solvers/0/seeds/2", "twice"},
      {{{"seeds", {1, -1}}}, "/solvers/0/seeds/1", "from 0"},
      {{{"seeds", {1.5}}}, "/solvers/0/seeds/0", "whole"},
      {{{"seeds", {2147483648}}}, "/solvers/0/seeds/0", "2147483647"},
      {{{"seeds", {1, 2}}, {"seed", 1}}, "/solvers/0/seeds", "remove one"}};
  for (const auto& [more, path, remedy] : cases) {
    const json value = learned(more);
    write_text(folder / "e.json", value.dump());
    const std::string message = refusal(folder / "e.json");
    EXPECT_NE(message.find(std::string("e.json: ") + path + ": "), std::string::npos) << message;
    EXPECT_NE(message.find(remedy), std::string::npos) << message;
    EXPECT_NE(schema_complaint(value), "") << more;
  }
}

TEST(Experiment, LabelsOfSeedsAndSweepsMustNotMeetOthers) {
  const TemporaryFolder folder("labels");
  json value = learned({{"seeds", {1, 2}}});
  value["solvers"][1]["label"] = "net.seed2";  // the name of a record
  write_text(folder / "e.json", value.dump());
  EXPECT_NE(refusal(folder / "e.json").find("/solvers/1/label: \"net.seed2\" is taken"),
            std::string::npos);
  value = learned({{"label", std::string(55, 'x')}, {"sweep", {{"level", {0.5}}}}});
  write_text(folder / "e.json", value.dump());
  EXPECT_NE(refusal(folder / "e.json").find("with the values of a sweep"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
