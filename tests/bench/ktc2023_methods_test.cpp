// Methods for KTC2023 beside those of its own room, and how its frames are made.

#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/files.h"
#include "tests/bench/ktc2023_testing.h"

namespace ertbench {
namespace {

nlohmann::json registered(const nlohmann::json& solver) {
  return {{"type", "registry"}, {"label", solver["type"]}, {"solver", solver}};
}

TEST(KtcMethods, EveryMethodFindsBothDiscsWithAndWithoutEightElectrodes) {
  const TemporaryFolder folder("ktc");
  SmallCompetition().write_training(folder.path(), [](Eigen::Index) { return 1; });
  const KtcResults results =
      results_in(folder.path(),
                 {{{"type", "gauss-newton"}},
                  {{"type", "lmmse"}, {"scenes", 300}},
                  registered({{"type", "one-step-gn"}, {"lambda", 0.03}}),
                  registered({{"type", "pdipm"}, {"alpha", 1e-5}}),
                  registered({{"type", "contacts"}, {"noise", 0.001}, {"prior_weight", 1}})},
                 1);
  ASSERT_EQ(results.rows.size(), 7u);  // the contacts twice, and the empty image
  EXPECT_EQ(results.rows[4].label, "contacts");
  EXPECT_EQ(results.rows[5].label, "contacts, Otsu");
  const KtcRow& empty = results.rows.back();
  for (std::size_t m = 0; m + 1 < results.rows.size(); ++m) {
    for (std::size_t level : {0, 1}) {
      EXPECT_GT(*results.rows[m].outcomes[level].score, *empty.outcomes[level].score + 0.1)
          << results.rows[m].label << ", " << level;
    }
  }
  EXPECT_GT(*results.rows[4].outcomes[0].score, 0.8);
  EXPECT_GT(*results.simulated[4].score_of(1), *results.simulated[6].score_of(1) + 0.3);
}

/// Networks that are told which electrodes are gone: one that is trained here on a few tanks, which
/// do not teach it to do without eight, and a stored one.
TEST(KtcMethods, NetworksFindBothDiscsTheStoredOneWithoutEightElectrodesToo) {
  const TemporaryFolder folder("ktc");
  SmallCompetition().write_training(folder.path(), [](Eigen::Index) { return 1; });
  const fs::path built = fs::path(ERTBENCH_PROGRAM).parent_path();
  if (!fs::exists(built / "libertbench_models.so")) GTEST_SKIP() << "no libtorch";
  ASSERT_EQ(setenv("ERTBENCH_PLUGINS", built.c_str(), 1), 0);
  ASSERT_EQ(setenv("ERTBENCH_CACHE", (folder.path() / "cache").c_str(), 1), 0);
  nlohmann::json trained = registered({{"type", "lean-net"},
                                       {"width", 8},
                                       {"output", "linear"},
                                       {"epochs", 12},
                                       {"front", true},
                                       {"training_faults", {{"dead_electrodes", {1, 12}}}}});
  nlohmann::json stored =
      registered({{"type", "lean-net"},
                  {"checkpoint", ERTBENCH_SOURCE_DIR "/results/networks/ktc2023/lean-net.fitted"}});
  for (auto* method : {&trained, &stored}) method->update({{"image_grid", 24}, {"scenes", 800}});
  const KtcResults results = results_in(folder.path(), nlohmann::json::array({trained, stored}));
  unsetenv("ERTBENCH_CACHE");
  unsetenv("ERTBENCH_PLUGINS");
  ASSERT_EQ(results.rows.size(), 5u);  // each also by Otsu, and the empty image
  const auto gain = [&](std::size_t row, std::size_t level) {
    return *results.rows[row].outcomes[level].score - *results.rows[4].outcomes[level].score;
  };
  EXPECT_GT(gain(0, 0), 0.1);
  EXPECT_GT(gain(2, 0), 0.4);
  EXPECT_GT(gain(2, 1), 0.4);
}

TEST(KtcMethods, NormalisedDifferencesDoNotSeeGainsOfChannels) {
  const TemporaryFolder folder("ktc");
  const auto gain = [](Eigen::Index channel) {
    return 1 + 0.3 * std::sin(1.7 * static_cast<double>(channel));
  };
  SmallCompetition().write_training(folder.path(), gain);
  const nlohmann::json method = {{"type", "level-set"}, {"difference", "normalised"}};
  const KtcResults results = results_in(folder.path(), nlohmann::json::array({method}));
  EXPECT_GT(*results.rows[0].outcomes[0].score, 0.75);
}

TEST(KtcMethods, SayWhatTheyCannotDo) {
  const TemporaryFolder folder("ktc");
  SmallCompetition().write_training(folder.path(), [](Eigen::Index) { return 1; });
  const auto message = [&](const nlohmann::json& method) -> std::string {
    try {
      results_in(folder.path(), nlohmann::json::array({method}));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(registered({{"type", "elsewhere"}})).find("/methods/0/solver"),
            std::string::npos);
  EXPECT_NE(
      message(registered({{"type", "lmmse"}, {"checkpoint", "nowhere.fitted"}})).find("nowhere"),
      std::string::npos);
  EXPECT_NE(message({{"type", "tsvd"}, {"calibration", "none"}}).find("/methods/0/calibration"),
            std::string::npos);
}

}  // namespace
}  // namespace ertbench
