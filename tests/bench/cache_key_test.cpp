// What the names of files in the cache follow.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "bench/record/measurement_records.h"
#include "solvers/registry/registry.h"
#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

TEST(Cache, WhatIsAppliedOtherwiseSharesItsFit) {
  const TemporaryFolder folder("inference_key");
  json value = good();
  value["solvers"] = json::parse(R"([
      {"type": "tsvd", "rank": 10}, {"type": "tsvd", "label": "a", "rank": 10,
       "inference_precision": "float32", "inference_averaging": false},
      {"type": "tsvd", "label": "b", "rank": 11}])");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
  const Cache cache("c");
  EXPECT_EQ(cache.fitted_solver(fit_recipe(e, e.solvers[0])),
            cache.fitted_solver(fit_recipe(e, e.solvers[1])));
  EXPECT_NE(cache.fitted_solver(fit_recipe(e, e.solvers[0])),
            cache.fitted_solver(fit_recipe(e, e.solvers[2])));
  EXPECT_NE(accuracy_key(e, e.solvers[0]), accuracy_key(e, e.solvers[1]));
}

TEST(Cache, ASeedOfManyHasTheKeyOfTheEntryWithThatSeedAlone) {
  const TemporaryFolder folder("seed_key");
  const Cache cache("c");
  const auto file = [&](const json& more, std::size_t entry) {
    write_text(folder / "e.json", learned(more).dump());
    SolverRegistry registry;
    const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
    return cache.fitted_solver(fit_recipe(e, e.solvers.at(entry)));
  };
  const auto alone = file({{"seed", 2}, {"level", 0.5}, {"label", "other"}}, 0);
  EXPECT_EQ(file({{"seeds", {1, 2}}, {"level", 0.5}}, 1), alone);
  EXPECT_EQ(file({{"seed", 2}, {"sweep", {{"level", {0.25, 0.5}}}}}, 1), alone);
  EXPECT_NE(file({{"seeds", {1, 2}}, {"level", 0.5}}, 0), alone);
}

TEST(Cache, KeyFollowsWhatDeterminesTheNumbersAndNothingElse) {
  const TemporaryFolder folder("key");
  const Cache cache("c");
  const auto keys = [&](const json& value) {
    write_text(folder / "e.json", value.dump());
    SolverRegistry registry;
    const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
    return std::pair{cache.dataset(*e.validation),
                     cache.fitted_solver(fit_recipe(e, e.solvers[1]))};
  };
  const auto original = keys(good());
  json same = good();
  same["title"] = "other";
  same["solvers"][1]["label"] = "other";
  same["datasets"]["validation"]["rasterisation"] = "area";  // the default, written out
  EXPECT_EQ(keys(same), original);
  json reseeded = good();
  reseeded["datasets"]["validation"]["seed"] = 3;
  EXPECT_NE(keys(reseeded).first, original.first);
  EXPECT_NE(keys(reseeded).second, original.second);
  json fixed = good();
  fixed["solvers"][1]["lambda"] = 0.1;
  EXPECT_EQ(keys(fixed).first, original.first);
  EXPECT_NE(keys(fixed).second, original.second);
}

}  // namespace
}  // namespace ertbench
