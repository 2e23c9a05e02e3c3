#include "bench/run/fidelity.h"

#include <gtest/gtest.h>

#include <numeric>

#include "bench/experiment/experiment.h"

namespace ertbench {
namespace {

Experiment experiment() {
  Experiment out;
  out.name = "fidelity";
  out.title = "Fidelity";
  DatasetSpec mixed;
  mixed.name = "mixed";
  mixed.count = 24;
  mixed.model = ContinuousSheet{};
  mixed.noise.snr_db = 50;
  SceneDistribution scenes;
  scenes.blank_fraction = 0.1;
  mixed.scenes = scenes;
  out.tests.push_back(mixed);
  return out;
}

TEST(Fidelity, AutoKeepsItsPromiseAndGridsConverge) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "dense systems of 2500 points take minutes there";
#endif
  const std::vector<FidelityRow> rows = measure_fidelity(experiment(), 24);
  ASSERT_EQ(rows.size(), 15u);  // smooth, other and all, each by five models
  int scenes = 0;
  for (std::size_t group = 0; group < rows.size(); group += 5) {
    const FidelityRow& automatic = rows[group];
    EXPECT_EQ(automatic.model, "auto");
    EXPECT_GE(automatic.kept, 0.95 * automatic.count);
    EXPECT_EQ(automatic.promised_kept, automatic.promised);
    EXPECT_EQ(std::accumulate(automatic.sizes.begin(), automatic.sizes.end(), 0), automatic.count);
    EXPECT_GT(automatic.time_us, 0);
    for (std::size_t grid = 2; grid < 5; ++grid) {
      EXPECT_LT(rows[group + grid].error_median, rows[group + grid - 1].error_median);
    }
    if (automatic.scenes != "all") scenes += automatic.count;
  }
  EXPECT_EQ(rows[10].scenes, "all");
  EXPECT_EQ(rows[10].count, scenes);
  EXPECT_LT(scenes, 24);  // the blank ones are left out
}

}  // namespace
}  // namespace ertbench
