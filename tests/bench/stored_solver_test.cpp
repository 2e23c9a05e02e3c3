// The fitted solvers of results/networks: by name as by file, on their sensor alone, in
// experiments, and as good as their cards say.

#include "solvers/check/stored_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench::testing {
namespace {

using nlohmann::json;

json card_of(const std::string& name) {
  return json::parse(read_text(stored_solver_file(name, ".json")));
}

void expect_refused(const Outcome& outcome, const std::string& reason) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.output;
  EXPECT_NE(outcome.output.find(reason), std::string::npos) << outcome.output;
}

RowMajorMatrix images_in(const fs::path& file) {
  const Hdf5File in = Hdf5File::open(file);
  return in.read_rows("/conductivity_change", 0, in.shape("/conductivity_change")[0]);
}

TEST(StoredSolver, ReconstructsByNameAsByFileAndOnlyForItsSensor) {
  const TemporaryFolder folder("stored");
  json experiment = small_experiment();
  write_text(folder / "small.json", experiment.dump());
  experiment["sensor"] = {{"electrode_count", 12}};
  write_text(folder / "other.json", experiment.dump());
  for (const char* name : {"small", "other"}) {
    const std::string file(name);
    ASSERT_EQ(run_program(folder.path(),
                          "generate " + file + ".json --dataset test --out " + file + ".h5")
                  .exit_code,
              0);
  }
  write_text(
      folder / "file.json",
      json{{"type", "lean-net"}, {"checkpoint", stored_solver_file("lean-net-8").string()}}.dump());
  for (const char* solver : {"lean-net-8", "file.json"}) {
    const Outcome outcome =
        run_program(folder.path(), std::string("reconstruct --input small.h5 --output images_") +
                                       solver + ".h5 --solver " + solver);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  EXPECT_EQ(images_in(folder / "images_lean-net-8.h5"), images_in(folder / "images_file.json.h5"));
  const std::string reconstruct = "reconstruct --output o.h5 --input ";
  expect_refused(run_program(folder.path(), reconstruct + "other.h5 --solver lean-net-8"),
                 "was fitted for the sensor");
  expect_refused(run_program(folder.path(), reconstruct + "small.h5 --solver lean-nett-8"),
                 "did you mean \"lean-net-8\"?");
}

TEST(StoredSolver, IsListedWithItsCard) {
  const TemporaryFolder folder("list");
  const Outcome outcome = run_program(folder.path(), "list --fitted");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const std::string& name : stored_solver_names()) {
    const json card = card_of(name);
    for (const char* key : {"type", "trained_on", "fails_beyond"}) {
      EXPECT_NE(outcome.output.find(card.at(key)), std::string::npos) << name << " " << key;
    }
  }
}

/// The first frames of the cards' test set for every stored solver; each must come as near to the
/// card's mean as its interval, widened to the smaller number of frames, allows.
TEST(StoredSolver, IsARowThatAgreesWithItsCard) {
  constexpr int frames = 100;
  const TemporaryFolder folder("row");
  json experiment = {{"timing", {{"enabled", false}}}, {"figure", {{"scenes", json::array()}}}};
  for (const std::string& name : stored_solver_names()) {
    const json card = card_of(name);
    experiment["datasets"]["test"] = card.at("datasets").at("test");
    experiment["solvers"].push_back(
        {{"type", card.at("type")}, {"label", name}, {"checkpoint", name}});
  }
  json& test = experiment["datasets"]["test"];
  for (const char* key : {"name", "sensor", "format_version"}) test.erase(key);
  test["count"] = frames;
  write_text(folder / "stored.json", experiment.dump());
  const Outcome outcome = run_program(folder.path(), "run stored.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json summary = summary_of(folder / "results/stored");
  for (const std::string& name : stored_solver_names()) {
    const json& row = row_of(summary, name);
    EXPECT_EQ(row.at("status"), "ok") << row.at("message");
    EXPECT_TRUE(row.at("fit_s").is_null());
    EXPECT_EQ(row.at("parameters").at("checkpoint"), name);
    const json said = card_of(name).at("relative_error");
    const double half = (said.at("ci95")[1].get<double>() - said.at("ci95")[0].get<double>()) / 2;
    const double widened = half * std::sqrt(said.at("frames").get<double>() / frames);
    EXPECT_NEAR(row.at("metrics").at("relative_error").at("mean"), said.at("mean"), widened)
        << name;
  }
}

TEST(StoredSolver, IsRefusedWhereItWouldHaveToBeFitted) {
  const TemporaryFolder folder("refused");
  const json stored = {{"type", "lean-net"}, {"checkpoint", "lean-net-8"}};
  const auto run = [&](const json& changes, const json& ladders = {}) {
    json experiment = small_experiment();
    experiment["solvers"] = {stored};
    if (!changes.is_null()) experiment["solvers"][0].update(changes);
    if (!ladders.is_null()) experiment["ladders"] = ladders;
    write_text(folder / "refused.json", experiment.dump());
    return run_program(folder.path(), "run refused.json");
  };
  expect_refused(run({{"seeds", {1, 2}}}), "/solvers/0/seeds: has no effect");
  expect_refused(run({{"sweep", {{"width", {8, 16}}}}}), "/solvers/0/sweep: has no effect");
  expect_refused(run({{"checkpoint", "lean-net"}}), "did you mean \"lean-net-8\"?");
  const json axis = {
      {"name", "width"}, {"solver", "lean-net"}, {"vary", "/width"}, {"levels", {4, 8}}};
  expect_refused(run({}, {{"dataset", "test"}, {"axes", {axis}}}), "is fitted");
  const Outcome other = run({{"width", 16}});  // found when it is loaded
  EXPECT_EQ(other.exit_code, 1) << other.output;
  EXPECT_NE(other.output.find("was fitted with \"width\": 8, not with 16"), std::string::npos)
      << other.output;
}

TEST(StoredSolver, IsComparedByACheckAsItIsAndNotOverTrainings) {
  const TemporaryFolder folder("compared");
  json experiment = small_experiment();
  experiment["solvers"] = {{{"type", "lean-net"}, {"checkpoint", "lean-net-8"}}};
  write_text(folder / "e.json", experiment.dump());
  const std::string check = "check e.json --baseline e.baseline --out check";
  const Outcome made = run_program(folder.path(), check + " --update");
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const json baseline = json::parse(read_text(folder / "e.baseline"));
  EXPECT_EQ(row_of(baseline, "lean-net").at("tolerance").at("class"), "linear") << baseline.dump();
  EXPECT_EQ(row_of(baseline, "lean-net").at("tolerance").at("relative"), 1e-4);
  const Outcome same = run_program(folder.path(), check);
  EXPECT_EQ(same.exit_code, 0) << same.output;
}

}  // namespace
}  // namespace ertbench::testing
