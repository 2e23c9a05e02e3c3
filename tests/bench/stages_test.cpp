#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "bench/features/features.h"
#include "bench/record/record_file.h"
#include "bench/run/datasets.h"
#include "bench/run/job_runner.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::TemporaryFolder;

/// Every stage that there is.
Stages all_stages() {
  Stages all = stages_of_run(Experiment());
  for (auto& stage : part_named("ladders").stages(0)) all.push_back(std::move(stage));
  for (auto& stage : part_named("studies").stages(0)) all.push_back(std::move(stage));
  for (auto& stage : stages_of_fidelity(20)) all.push_back(std::move(stage));
  return all;
}

/// Labels and datasets that look like names of jobs.
class StagesTest : public ::testing::Test {
 protected:
  StagesTest() {
    json object = testing::small_experiment();
    object["datasets"]["tsvd"] = object["datasets"]["test"];
    object["datasets"]["accuracy"] = object["datasets"]["test"];
    object["solvers"] = json::parse(R"([
        {"type": "tsvd", "rank": 30}, {"type": "tsvd", "label": "tsvd.timing", "rank": 30},
        {"type": "tsvd", "label": "tsvd.timing.0", "rank": 20},
        {"type": "tsvd", "label": "tsvd.accuracy", "rank": 20},
        {"type": "tsvd", "label": "swept", "sweep": {"rank": [10, 20]}}])");
    object["timing"] = {{"rounds", 3}};
    object["ladders"] =
        json::parse(R"({"axes": [{"name": "snr", "vary": "/snr_db", "levels": [80, 40]}]})");
    testing::write_text(folder_ / "e.json", object.dump());
    SolverRegistry registry;
    experiment_ = read_experiment(folder_ / "e.json", registry, {});
  }

  TemporaryFolder folder_{"stages"};
  Experiment experiment_;
};

TEST_F(StagesTest, NoTwoJobsShareAFile) {
  std::set<std::string> stages;
  std::set<std::string> names;
  std::size_t count = 0;
  for (const auto& stage : all_stages()) {
    EXPECT_TRUE(stages.insert(stage->name()).second) << stage->name();
    for (const Job& job : stage->jobs(experiment_)) {
      EXPECT_TRUE(names.insert(job.name).second) << job.name;
      ++count;
    }
  }
  // 6 solvers scored, in three rounds timed, on ladders; 4 datasets for fidelity.
  EXPECT_EQ(count, 6u + 3 * 6 + 6 + 4);
}

TEST_F(StagesTest, FilesAreCalledWhatTheyWereAlwaysCalled) {
  std::set<std::string> names;
  for (const auto& stage : all_stages()) {
    for (const Job& job : stage->jobs(experiment_)) names.insert(job.name);
  }
  for (const char* name : {"tsvd.accuracy", "tsvd.timing.0", "tsvd.timing.2", "tsvd.ladders",
                           "swept rank=10.accuracy", "validation.fidelity"}) {
    EXPECT_TRUE(names.contains(name)) << name;
  }
  EXPECT_EQ(record_file("results/x", "tsvd.timing.2"), "results/x/records/tsvd.timing.2.json");
  EXPECT_EQ(record_file("x", "tsvd.ladders", ".log"), "x/records/tsvd.ladders.log");
}

TEST_F(StagesTest, KeysFollowTheJob) {
  for (const auto& stage : all_stages()) {
    std::map<std::string, std::string> keys;  // by subject
    for (const Job& job : stage->jobs(experiment_)) {
      const std::string key = stage->key(experiment_, job);
      const auto [found, added] = keys.emplace(job.subject, key);
      EXPECT_EQ(found->second, key) << "rounds of one subject differ: " << job.name;
      if (!added) continue;
      for (const auto& [other, its_key] : keys) {
        EXPECT_EQ(its_key == key, other == job.subject) << job.name << " and " << other;
      }
    }
  }
}

TEST_F(StagesTest, ClocksRunAloneAndFidelityNeedsNoSolver) {
  EXPECT_FALSE(stage_named("accuracy", 20)->wants_machine_alone());
  EXPECT_TRUE(stage_named("timing", 20)->wants_machine_alone());
  EXPECT_FALSE(stage_named("ladders", 20)->wants_machine_alone());
  const std::unique_ptr<Stage> fidelity = stage_named("fidelity", 20);
  EXPECT_TRUE(fidelity->wants_machine_alone());
  EXPECT_FALSE(fidelity->reads_datasets());
  for (const Job& job : fidelity->jobs(experiment_)) EXPECT_EQ(job.entry, nullptr);
}

TEST_F(StagesTest, WhatWasReadOutOfTheImagesIsKeptWhereItIsAskedFor) {
  const std::unique_ptr<Stage> stage = stage_named("accuracy", 20);
  const Cache cache(folder_ / "cache");
  const Job job = stage->jobs(experiment_).front();
  const auto collected = [&](bool keep) {
    experiment_.keep_contacts = keep;
    SolverRegistry registry;
    std::filesystem::create_directories(folder_ / "cache/datasets");
    std::filesystem::create_directories(folder_ / "cache/solvers");
    for (const DatasetSpec* spec : experiment_.datasets()) ensure_dataset(*spec, cache, 1);
    JobRecords records(*stage, experiment_, folder_.path());
    std::filesystem::create_directories(folder_ / "records");
    run_trial(*stage, job.name, experiment_, cache, registry, 1, folder_.path());
    EXPECT_TRUE(records.accept(job));
    ExperimentResults results;
    stage->collect(experiment_, cache, records, results);
    return results;
  };
  EXPECT_TRUE(collected(false).readings.empty());
  const ExperimentResults results = collected(true);
  ASSERT_EQ(results.readings.size(), 1u);
  const auto& readings = results.readings.at(job.entry->label);
  ASSERT_EQ(readings.size(), 3u) << "one list for each test set";
  ASSERT_EQ(readings.at("test").size(), 1u) << "one list for each training";
  EXPECT_EQ(readings.at("test").front().size(), 40u);
  EXPECT_FALSE(readings.at("test").front().front().contacts.empty());
  for (const ResultRow& row : results.rows) {
    if (row.label != job.entry->label) continue;
    EXPECT_EQ(row.parameters->at("contacts").at("chosen_on"), 30) << "of the validation set";
    EXPECT_GT(row.parameters->at("contacts").at("threshold"), 0);
  }
}

TEST_F(StagesTest, APartThatIsNotBuiltIsSaidByName) {
  try {
    part_named("nobody");
    FAIL() << "found a part called nobody";
  } catch (const PartMissing& missing) {
    EXPECT_EQ(missing.part(), "nobody");
  }
}

TEST_F(StagesTest, NamesThatDoNotExistAreRefused) {
  try {
    stage_named("speed", 20);
    FAIL() << "found a stage called speed";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("accuracy, timing, ladders, folds, hours, studies, fidelity"),
              std::string::npos)
        << error.what();
  }
  SolverRegistry registry;
  EXPECT_THROW(run_trial(*stage_named("accuracy", 20), "nobody.accuracy", experiment_,
                         Cache(folder_ / "cache"), registry, 1, folder_.path()),
               InputError);
}

TEST_F(StagesTest, RecordsThatAreNotTheStagesOwnAreNone) {
  for (const auto& stage : all_stages()) {
    if (stage->jobs(experiment_).empty()) continue;  // studies
    const Job job = stage->jobs(experiment_).front();
    const JobRecords records(*stage, experiment_, folder_.path());
    EXPECT_FALSE(records.read(job)) << job.name;
    const std::string key = stage->key(experiment_, job);
    std::filesystem::create_directories(folder_ / "records");
    write_record(records.file(job), {{"rows", 3}}, key, stamp_of_record(experiment_, job.entry));
    EXPECT_FALSE(records.read(job)) << job.name << ": the right key alone is not enough";
    testing::write_text(records.file(job), "{\"key\": \"" + key);
    EXPECT_FALSE(records.read(job)) << job.name << ": cut off";
  }
  const std::unique_ptr<Stage> stage = stage_named("fidelity", 20);
  const Job job = stage->jobs(experiment_).front();
  const JobRecords records(*stage, experiment_, folder_.path());
  const json sound = {{"models", json::object()}};
  write_record(records.file(job), sound, stage->key(experiment_, job),
               stamp_of_record(experiment_, job.entry));
  EXPECT_TRUE(records.read(job));
  write_record(records.file(job), sound, "of another experiment",
               stamp_of_record(experiment_, job.entry));
  EXPECT_FALSE(records.read(job));
}

}  // namespace
}  // namespace ertbench
