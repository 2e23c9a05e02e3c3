// What is submitted to a cluster, and what Slurm says of it. tests/slurm/run has a real one.

#include "bench/cluster/slurm.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "core/errors.h"
#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

std::vector<int> elements_of(const std::string& text) {
  std::vector<int> out;
  for (const SlurmTask& task : tasks_from("12|" + text + "|PENDING|\n")) {
    out.push_back(task.element.value_or(-1));
  }
  return out;
}

TEST(Slurm, ReadsWhatSqueueSays) {
  const std::vector<SlurmTask> tasks =
      tasks_from("7|N/A|RUNNING|node3\n8|4|RUNNING|node4\n8|5-6|PENDING|\n");
  ASSERT_EQ(tasks.size(), 4u);
  EXPECT_EQ(tasks[0].job, 7);
  EXPECT_FALSE(tasks[0].element.has_value());
  EXPECT_EQ(tasks[1].node, "node4");
  EXPECT_EQ(tasks[3].element, 6);
  EXPECT_TRUE(tasks[3].waits());
  EXPECT_EQ(elements_of("[3,7-9%2]"), (std::vector<int>{3, 7, 8, 9}));
  EXPECT_EQ(elements_of("0-8:4"), (std::vector<int>{0, 4, 8}));
  EXPECT_THROW(elements_of("[1-2,...]"), InputError);
  EXPECT_TRUE(tasks_from("").empty());
  EXPECT_THROW(tasks_from("12|a|PENDING|\n"), InputError);
  EXPECT_THROW(tasks_from("slurm_load_jobs error\n"), InputError);
}

class SlurmPlanOf : public ::testing::Test {
 protected:
  Experiment read(const json& more) {
    json value = good();
    value.update(more);
    write_text(folder_ / "e.json", value.dump());
    return read_experiment(folder_ / "e.json", registry_, chart_types());
  }
  std::vector<SlurmPart> plan(const Experiment& experiment, const LiveUnits& live = {},
                              int most_elements = 1001) {
    SlurmOptions options;
    options.out = folder_ / "out";
    return slurm_plan(experiment, Cache(folder_ / "cache"), live, options, most_elements);
  }

  const TemporaryFolder folder_{"slurm_plan"};
  SolverRegistry registry_;
};

TEST_F(SlurmPlanOf, AnExperimentHasEachOfItsParts) {
  const Experiment experiment = read({{"timing", {{"rounds", 2}}}});
  const std::vector<SlurmPart> parts = plan(experiment);
  ASSERT_EQ(parts.size(), 4u);
  EXPECT_EQ(parts[0].name, "datasets");
  EXPECT_EQ(parts[0].elements.size(), experiment.datasets().size());
  EXPECT_EQ(parts[1].name, "accuracy");
  EXPECT_EQ(parts[1].elements.size(), experiment.solvers.size());
  EXPECT_FALSE(parts[1].exclusive);
  EXPECT_EQ(parts[2].name, "timing");
  EXPECT_TRUE(parts[2].exclusive);
  ASSERT_EQ(parts[2].elements.size(), 1u);  // all rows in turn on one node
  EXPECT_EQ(parts[2].elements[0].size(), experiment.rows().size());
  EXPECT_EQ(parts[3].name, "report");
}

TEST_F(SlurmPlanOf, TooManyUnitsShareElementsAndNoneIsLost) {
  const Experiment experiment = read({{"timing", {{"enabled", false}}}});
  const std::vector<SlurmPart> parts = plan(experiment, {}, 2);
  const SlurmPart& fits = parts.at(1);
  EXPECT_EQ(fits.elements.size(), 2u);
  Units all;
  for (const Units& units : fits.elements) all.insert(all.end(), units.begin(), units.end());
  Units expected;
  for (const SolverEntry& entry : experiment.solvers) expected.push_back(entry.stem());
  EXPECT_EQ(all, expected);
}

TEST_F(SlurmPlanOf, WhatWaitsOrRunsIsNotPlanned) {
  const Experiment experiment = read({{"timing", {{"enabled", false}}}});
  LiveUnits live;
  live.emplace("accuracy", experiment.solvers[0].stem());
  const std::vector<SlurmPart> parts = plan(experiment, live);
  EXPECT_EQ(parts.at(1).elements.size(), experiment.solvers.size() - 1);
  for (const SolverEntry& entry : experiment.solvers) live.emplace("accuracy", entry.stem());
  const std::vector<SlurmPart> rest = plan(experiment, live);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].name, "report");
}

TEST_F(SlurmPlanOf, AScriptSaysWhatAnElementIsTold) {
  const Experiment experiment = read({{"memory_limit_mb", 1000}});
  SlurmOptions options;
  options.out = folder_ / "a result's 100%";
  options.partition = "short";
  options.array_limit = 7;
  options.threads = 3;
  const std::string script = slurm_script(experiment, Cache("cache"), options, "accuracy", 40,
                                          false, options.out / "slurm/1.accuracy.json");
  for (const char* part :
       {"#SBATCH \"--array=0-39%7\"", "\"--cpus-per-task=3\"", "\"--partition=short\"",
        "\"--mem=1512M\"", "\"--requeue\"", "100%%/slurm/1.accuracy.%a.log\"", "result'\\''s 100%",
        "--element \"$SLURM_ARRAY_TASK_ID\"", "--threads 3"}) {
    EXPECT_NE(script.find(part), std::string::npos) << part << "\n" << script;
  }
  EXPECT_EQ(script.find("--exclusive"), std::string::npos);
}

TEST(Slurm, SubmissionsAreKeptForTheNextCommand) {
  const TemporaryFolder folder("submissions");
  Submissions first(folder.path());
  first.add({12, "accuracy", {{"a", "b"}, {"c"}}});
  first.add({13, "report", {{}}});
  Submissions next(folder.path());
  EXPECT_EQ(next.jobs(), (std::vector<long>{12, 13}));
  EXPECT_EQ(next.jobs_of({"report"}), std::vector<long>{13});
  const LiveUnits live = next.units_of({{12, 0, "RUNNING", "node1"}, {99, 1, "RUNNING", "node1"}});
  EXPECT_TRUE(live.contains({"accuracy", "a"}) && live.contains({"accuracy", "b"}));
  EXPECT_FALSE(live.contains({"accuracy", "c"}));
  next.keep({{13, std::nullopt, "PENDING", ""}});
  EXPECT_EQ(next.jobs(), std::vector<long>{13});
  write_text(folder / "submitted.json", "{}");
  EXPECT_THROW(Submissions(folder.path()), InputError);
}

}  // namespace
}  // namespace ertbench
