#include "bench/publish/publish_plan.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/experiment/solver_entry.h"
#include "bench/features/features.h"
#include "bench/record/limit_file.h"
#include "bench/record/stamps.h"
#include "core/build_stamp.h"
#include "solvers/registry/registry.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

TEST(PublishPlan, CountsTheFitsAndLimitsThatAreOfOtherProbes) {
  const TemporaryFolder folder("plan");
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}},
                           {{"type", "tsvd"}, {"label", "another"}, {"rank", 20}}};
  write_text(folder / "e.json", experiment.dump());
  fs::create_directories(folder / "results/published/e");
  write_text(folder / "results/published/e/summary.json",
             json{{"rows", {{{"label", "tsvd"}, {"fit_s", 7200}}}}}.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
  const Cache cache(folder / "cache");
  const auto plan = [&] {
    PublishPlan out(folder.path(), cache);
    out.add(e);
    return out;
  };
  /// Cells of the experiment's row: its name, fits, kept, hours, of unknown length, hours of
  /// limits.
  const auto row = [&] {
    std::vector<std::string> cells;
    const Table table = plan().table(2);
    for (const Cell& cell : table.sections.at(0).rows.at(0)) cells.push_back(cell.text);
    return cells;
  };
  EXPECT_EQ(row(), (std::vector<std::string>{"e", "2", "0", "2.00", "1", "0.00"}));
  EXPECT_EQ(plan().table(2).sections.at(0).notes.at(0),
            "Some 1.0 hours of fits and limits with 2 at a time.");

  const fs::path fitted = cache.fitted_solver(fit_recipe(e, e.solvers.at(1)));
  fs::create_directories(fitted.parent_path());
  write_text(fitted, "");
  BuildStamp stamp = stamp_of_fit(fit_recipe(e, e.solvers.at(1)));
  stamp.dirty = false;
  const auto note = [&] {
    write_text(fitted.string() + ".json", json{{"build", to_json(stamp)}, {"fit_s", 3600}}.dump());
  };
  note();
  EXPECT_EQ(row(), (std::vector<std::string>{"e", "2", "1", "2.00", "0", "0.00"}));
  // The solver computes something else today: again, and for as long.
  stamp.probes.at("solver/tsvd").numbers.at(0) += 1;
  note();
  EXPECT_EQ(row(), (std::vector<std::string>{"e", "2", "0", "3.00", "0", "0.00"}));
  write_text(fitted.string() + ".json", "{");
  EXPECT_EQ(row(), (std::vector<std::string>{"e", "2", "0", "2.00", "1", "0.00"}));

  // Limits of these probes and sets stay; of others they are made again, for as long as they
  // took.
  ResultRow limit;
  limit.type = limit.label = limit_oracle;
  limit.dataset = "test";
  limit.parameters = json{{"set", limit_key(e.tests.at(0), e.tests.at(0))}};
  BuildStamp made = stamp_of_limit(e.tests.at(0), e.tests.at(0));
  made.dirty = false;
  const auto limits = [&] {
    limit.build.scored = {made};
    json frames = json::array();
    for (const double seconds : {1800, 5400}) frames.push_back({{"seconds", seconds}});
    const json set = {{"dataset", "test"}, {"prior", "oracle"}, {"per_frame", frames}};
    write_text(folder / "results/published/e/limit.json",
               json{{"rows", {to_json(limit)}}, {"sets", {set}}}.dump());
  };
  limits();
  EXPECT_EQ(row().back(), "0.00");
  made.probes.begin()->second.numbers.at(0) += 1;
  limits();
  EXPECT_EQ(row().back(), "2.00");
  EXPECT_EQ(plan().table(2).sections.at(0).rows.back().back().text, "2.00");
  write_text(folder / "results/published/e/limit.json", "{");
  EXPECT_EQ(row().back(), "0.00");
}

}  // namespace
}  // namespace ertbench
