// `ertbench check` as users call it: images of stored solvers and of short trainings.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "tests/bench/checked_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

TEST(CheckImages, StoredSolversMustMakeTheImagesThatTheyOnceMade) {
  CheckedExperiment small("stored");
  const fs::path networks = small.folder() / "networks";
  fs::create_directories(networks);
  write_text(networks / "small tsvd.json", R"({"type": "tsvd", "rank": 20})");
  write_text(networks / "other.json", R"({"type": "pdipm"})");  // not in the experiment
  EXPECT_EQ(small.check("--update").exit_code, 1);              // no frames yet
  ASSERT_EQ(run_program(small.folder().path(),
                        "generate small.json --dataset test --out networks/frames.h5")
                .exit_code,
            0);
  const std::string images = "'networks/small tsvd.images.h5'";
  ASSERT_EQ(run_program(small.folder().path(),
                        "reconstruct --solver 'networks/small tsvd.json' --input "
                        "networks/frames.h5 --output " +
                            images)
                .exit_code,
            0);
  ASSERT_EQ(small.check("--update").exit_code, 0);
  Outcome outcome = small.check("--all");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "stored small tsvd")) << outcome.output;
  EXPECT_FALSE(contains(outcome, "stored other")) << outcome.output;
  {
    Hdf5File file = Hdf5File::open_writable(networks / "small tsvd.images.h5");
    RowMajorMatrix changed = file.read_rows("/conductivity_change", 5, 1);
    changed *= 1.0002;
    file.write_rows("/conductivity_change", 5, changed);
  }
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok, 1 worse")) << outcome.output;
  fs::rename(networks, small.folder() / "elsewhere");  // a comparison must not be lost unnoticed
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok, 1 missing")) << outcome.output;
  fs::rename(small.folder() / "elsewhere", networks);
  write_text(networks / "small tsvd.json", R"({"type": "tsvd", "checkpoint": "absent.fitted"})");
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "failed; see results/small/check/networks/small tsvd.log"))
      << outcome.output;
}

TEST(CheckImages, ShortTrainingsMustMakeTheImagesThatTheyMadeAndAreRenewedWithTheBaseline) {
  CheckedExperiment small("trainings");
  json trainings = small_experiment();
  trainings["solvers"] = {{{"type", "tsvd"}, {"rank", 20}, {"label", "short"}},
                          {{"type", "pdipm"}, {"alpha", 1e-4}}};  // not in the experiment
  trainings["timing"] = {{"enabled", false}};
  fs::create_directories(small.folder() / "trainings");
  const auto write = [&] {
    write_text(small.folder() / "trainings/experiment.json", trainings.dump());
  };
  write();
  Outcome outcome = small.check("--update");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(fs::exists(small.folder() / "trainings/short.images.h5"));
  outcome = small.check("--all");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "trained short")) << outcome.output;
  EXPECT_FALSE(contains(outcome, "trained pdipm")) << outcome.output;

  outcome = small.check("--images");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "1 row ok")) << outcome.output;

  small.rebuild("1");  // which trains anew
  EXPECT_EQ(small.check("--images").exit_code, 0);

  trainings["solvers"][0]["rank"] = 19;  // as if the program made it otherwise
  write();
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "4 rows ok, 1 worse")) << outcome.output;
  EXPECT_EQ(small.check("--images").exit_code, 1);
  outcome = small.check("--update");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_TRUE(contains(outcome, "trained short")) << outcome.output;
  EXPECT_EQ(small.check().exit_code, 0);
  fs::rename(small.folder() / "trainings", small.folder() / "elsewhere");
  outcome = small.check("--images");
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "1 row missing")) << outcome.output;
  fs::rename(small.folder() / "elsewhere", small.folder() / "trainings");
  fs::remove(small.folder() / "trainings/short.images.h5");
  outcome = small.check();
  EXPECT_EQ(outcome.exit_code, 1) << outcome.output;
  EXPECT_TRUE(contains(outcome, "1 missing")) << outcome.output;
}

}  // namespace
}  // namespace ertbench
