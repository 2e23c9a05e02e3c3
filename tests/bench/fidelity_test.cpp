#include "bench/fidelity/fidelity.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/bench/small_experiment.h"
#include "tests/under_sanitizers.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::TemporaryFolder;

TEST(Fidelity, AutoKeepsItsPromiseAndGridsConverge) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  DatasetSpec mixed;
  mixed.name = "mixed";
  mixed.count = 24;
  mixed.model = ContinuousSheet{};
  mixed.noise.snr_db = 50;
  SceneDistribution distribution;
  distribution.blank_fraction = 0.1;
  mixed.scenes = distribution;
  std::uint64_t last = 0;
  const FidelityRecord record =
      measure_fidelity(mixed, 24, [&](std::uint64_t done, std::uint64_t) { last = done; });
  EXPECT_GT(last, 0u);
  // What is reported is what comes back from the file.
  const FidelityRecord again = fidelity_record_from_json(to_json(record));
  EXPECT_EQ(to_json(again), to_json(record));
  const std::vector<FidelityRow> rows = fidelity_rows(mixed, again);
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

TEST(Fidelity, KeyFollowsTheDatasetAndTheScenesThatItHas) {
  DatasetSpec set;
  set.name = "few";
  set.count = 30;
  const std::string key = fidelity_key(set, 30);
  EXPECT_EQ(fidelity_key(set, 500), key) << "there are but 30";
  EXPECT_NE(fidelity_key(set, 29), key);
  DatasetSpec other = set;
  other.seed = 7;
  EXPECT_NE(fidelity_key(other, 30), key);
}

/// Two datasets of smooth scenes, which are quick.
class FidelityProgram : public ::testing::Test {
 protected:
  FidelityProgram() {
    json object = testing::small_experiment();
    object["datasets"].erase("validation");
    object["datasets"]["more"] = object["datasets"]["test"];
    object["solvers"] = json::parse(R"([{"type": "tsvd", "rank": 30}])");
    testing::write_text(folder_ / "e.json", object.dump());
  }
  void run(const std::string& options = "--scenes 10") {
    const testing::Outcome outcome =
        testing::run_program(folder_.path(), "fidelity e.json --out r " + options);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    output_ = outcome.output;
  }
  testing::fs::path record(const std::string& dataset) const {
    return folder_ / ("r/records/" + dataset + ".fidelity.json");
  }
  std::map<std::string, std::string> records() const {
    std::map<std::string, std::string> out;
    for (const char* name : {"test", "more"}) out[name] = testing::read_text(record(name));
    return out;
  }

  TemporaryFolder folder_{"fidelity"};
  std::string output_;
};

TEST_F(FidelityProgram, ResumesAndMakesDamagedRecordsAgain) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  run();
  EXPECT_NE(output_.find("fidelity of 2 datasets"), std::string::npos) << output_;
  EXPECT_FALSE(testing::fs::exists(folder_ / "cache/datasets")) << "it needs no datasets";
  const auto before = records();
  const std::string table = testing::read_text(folder_ / "r/fidelity.csv");
  EXPECT_NE(table.find("\ntest,all,auto,10,"), std::string::npos) << table;
  EXPECT_NE(table.find("\nmore,all,192,10,"), std::string::npos) << table;
  for (const char* file : {"fidelity.md", "fidelity.svg", "fidelity.png", "provenance.json"}) {
    EXPECT_TRUE(testing::fs::exists(folder_ / "r" / file)) << file;
  }

  // Nothing is measured again: times would not come out the same to the last digit.
  run();
  EXPECT_EQ(output_.find("fidelity of"), std::string::npos) << output_;
  EXPECT_EQ(records(), before);
  EXPECT_EQ(testing::read_text(folder_ / "r/fidelity.csv"), table);

  // One that is damaged, and it alone.
  testing::write_text(record("more"), before.at("more").substr(0, before.at("more").size() / 2));
  run();
  EXPECT_NE(output_.find("fidelity of 1 dataset"), std::string::npos) << output_;
  EXPECT_EQ(records().at("test"), before.at("test"));
  EXPECT_EQ(json::parse(records().at("more")).at("key"), json::parse(before.at("more")).at("key"));

  // Other scenes are another record.
  run("--scenes 12");
  EXPECT_NE(output_.find("fidelity of 2 datasets"), std::string::npos) << output_;
  EXPECT_EQ(json::parse(records().at("test")).at("models").at("auto").at("error").size(), 12u);
  run("--scenes 12");
  EXPECT_EQ(output_.find("fidelity of"), std::string::npos) << output_;
  run("--scenes 12 --fresh");
  EXPECT_NE(output_.find("fidelity of 2 datasets"), std::string::npos) << output_;
}

}  // namespace
}  // namespace ertbench
