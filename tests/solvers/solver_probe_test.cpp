#include "solvers/registry/solver_probe.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/json.h"

namespace ertbench {
namespace {

TEST(SolverProbe, ANewTypeOfSolversChangesNoOther) {
  SolverRegistry before;
  SolverRegistry after;
  SolverInfo info = after.load("tsvd");
  info.summary = "another name for the same";
  after.add("truncated", info);
  const Probe tsvd = computed_solver_probe(before, "tsvd");
  EXPECT_EQ(computed_solver_probe(after, "tsvd").numbers, tsvd.numbers);
  // It has a probe without a line of its own, that of the solver that it is.
  EXPECT_EQ(computed_solver_probe(after, "truncated").numbers, tsvd.numbers);
}

TEST(SolverProbe, TellsSolversAndSettingsApart) {
  SolverRegistry registry;
  SolverInfo info = registry.load("tsvd");
  info.probes = {R"({"rank": 30})"};
  registry.add("rank-30", info);
  info.probes = {R"({"rank": 31})"};
  registry.add("rank-31", info);
  EXPECT_GT(difference(computed_solver_probe(registry, "rank-30"),
                       computed_solver_probe(registry, "rank-31")),
            10 * Probe::rounding);
}

TEST(SolverProbe, AStoredFitOfTheLastReleasePasses) {
  SolverRegistry registry;
  // A stamp without probes, as release 0.2.0 wrote it beside a fit.
  for (const char* type : {"one-step-gn", "tsvd", "lmmse"}) {
    const Probes now = {{std::string("solver/") + type, computed_solver_probe(registry, type)}};
    EXPECT_EQ(probe_difference({}, now), "");
  }
}

// Results from before it was recorded are valid by these numbers; those with loose or half-dead
// electrodes were made anew.
TEST(SolverProbe, TheFrontIsThatOfThePublishedResults) {
  const Probe now = front_probe();
  ASSERT_EQ(now.numbers.size(), 3u * 3 * Probe::projections);
  EXPECT_EQ(probe_difference({{"a", {}}}, {{"front", now}}), "");
  EXPECT_EQ(probe_difference({{"front", {}}}, {{"front", now}}),
            "the probe front has other numbers");
}

TEST(SolverProbe, SolversOfTheUsersHaveNone) {
  EXPECT_FALSE(solver_probe("my-own-method").has_value());
  EXPECT_FALSE(solver_probe("command").has_value());
}

}  // namespace
}  // namespace ertbench
