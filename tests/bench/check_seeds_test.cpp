// The experiment that is trained over seeds: the same but for that.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/check/stored_images.h"
#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "core/files.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

Experiment read(const fs::path& file, const std::vector<std::string>& overrides = {}) {
  SolverRegistry registry;
  return read_experiment(file, registry, chart_types(), SolverCheck::all, overrides);
}

Experiment over_seeds(const Experiment& experiment) {
  return read(experiment.file, overrides_for_seeds(experiment, {"fcnn"}, 3));
}

TEST(CheckSeeds, KeepWhatScoresDependOn) {
  const Experiment skin =
      read(fs::path(ERTBENCH_SOURCE_DIR) / "experiments" / "skin.json", {"time_limit_s=77"});
  const Experiment copy = over_seeds(skin);
  ASSERT_EQ(copy.tests.size(), skin.tests.size());
  for (std::size_t i = 0; i < copy.tests.size(); ++i) {
    EXPECT_EQ(to_json(copy.tests[i]), to_json(skin.tests[i]));
  }
  EXPECT_EQ(copy.time_limit_s, 77);
  EXPECT_FALSE(copy.timing.enabled);
  ASSERT_EQ(copy.solvers.size(), 3u);
  for (const SolverEntry& entry : copy.solvers) EXPECT_EQ(entry.label, "fcnn");
  EXPECT_TRUE(copy.studies.empty());
}

TEST(CheckSeeds, KeepHowContactsAreMatched) {
  const TemporaryFolder folder("seeds");
  const fs::path quick = fs::path(ERTBENCH_SOURCE_DIR) / "experiments" / "targets_quick.json";
  const nlohmann::json closer = {{"extends", quick.string()}, {"contacts", {{"match_mm", 7}}}};
  write_file_atomically(folder.path() / "closer.json", closer.dump());
  const Experiment touch = read(folder.path() / "closer.json");
  const Experiment copy = over_seeds(touch);
  EXPECT_EQ(touch.contacts.match_mm, 7);
  EXPECT_EQ(copy.contacts.match_mm, touch.contacts.match_mm);
  EXPECT_EQ(copy.contacts.ospa_mm, touch.contacts.ospa_mm);
}

}  // namespace
}  // namespace ertbench
