// What lies in the cache and among the records is believed only where it is what was written.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "core/hdf5_file.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// The one file in a folder whose name begins and ends so.
fs::path file_in(const fs::path& folder, const std::string& begin, const std::string& end) {
  fs::path found;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(begin) || !name.ends_with(end)) continue;
    EXPECT_TRUE(found.empty()) << "both " << found << " and " << entry.path();
    found = entry.path();
  }
  EXPECT_FALSE(found.empty()) << begin << "*" << end << " in " << folder;
  return found;
}

/// Two runs of one experiment with something done to what the first one left.
class CacheIntegrity : public ::testing::Test {
 protected:
  CacheIntegrity() {
    json experiment = small_experiment();
    experiment["timing"] = {{"enabled", false}};
    experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}};
    write_text(folder_ / "small.json", experiment.dump());
    const Outcome outcome = run_program(folder_.path(), "run small.json");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    rows_ = rows();
  }

  json rows() const {
    json out = json::array();
    const json summary = summary_of(folder_ / "results/small");
    for (const json& row : summary.at("rows")) {
      out.push_back({row.at("label"), row.at("metrics")});
    }
    return out;
  }

  /// Runs again, everything but the datasets anew where asked; the numbers must be the same.
  std::string run_again(const std::string& options = "") {
    const Outcome outcome = run_program(folder_.path(), "run small.json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    EXPECT_EQ(rows(), rows_);
    return outcome.output;
  }

  fs::path dataset(const std::string& name) const {
    return file_in(folder_ / "cache/datasets", name + "-", ".h5");
  }
  fs::path fitted(const std::string& ending) const {
    return file_in(folder_ / "cache/solvers", "tsvd-", ending);
  }
  void remove_record() { fs::remove(folder_ / "results/small/records/tsvd.accuracy.json"); }

  TemporaryFolder folder_{"cache"};
  json rows_;
};

TEST_F(CacheIntegrity, AChangedDatasetIsMadeAgain) {
  {
    Hdf5File file = Hdf5File::open_writable(dataset("test"));
    RowMajorMatrix frame = file.read_rows("/voltages", 3, 1);
    frame(0, 7) *= 1.5;
    file.write_rows("/voltages", 3, frame);
  }
  const std::string said = run_again("--fresh");
  EXPECT_NE(said.find("dataset \"test\" is made again: it has been changed since it was written"),
            std::string::npos)
      << said;
}

TEST_F(CacheIntegrity, AnotherDatasetUnderItsNameIsMadeAgain) {
  fs::copy_file(dataset("validation"), dataset("test"), fs::copy_options::overwrite_existing);
  const std::string said = run_again("--fresh");
  EXPECT_NE(said.find("dataset \"test\" is made again: it is another dataset than its name says"),
            std::string::npos)
      << said;
}

TEST_F(CacheIntegrity, ADamagedDatasetIsMadeAgain) {
  fs::resize_file(dataset("test"), fs::file_size(dataset("test")) / 2);
  const std::string said = run_again("--fresh");
  EXPECT_NE(said.find("dataset \"test\" is made again"), std::string::npos) << said;
}

TEST_F(CacheIntegrity, AChangedFittedSolverIsFittedAgain) {
  {
    Hdf5File file = Hdf5File::open_writable(fitted(".fitted"));
    // As a file from before there was a check of frames has none.
    file.write_text("/", "another", "attribute");
  }
  remove_record();
  run_again();
  const std::string log = read_text(folder_ / "results/small/records/tsvd.accuracy.log");
  EXPECT_NE(log.find("is made again: its file has been changed since it was written"),
            std::string::npos)
      << log;
}

TEST_F(CacheIntegrity, AChangedNoteOfAFitIsNotBelieved) {
  json note = json::parse(read_text(fitted(".fitted.json")));
  note["fit_s"] = 1e-9;
  write_text(fitted(".fitted.json"), note.dump());
  remove_record();
  run_again();
  const std::string log = read_text(folder_ / "results/small/records/tsvd.accuracy.log");
  EXPECT_NE(log.find("is made again: it has been changed since it was written"), std::string::npos)
      << log;
}

TEST_F(CacheIntegrity, AChangedRecordIsMadeAgain) {
  const fs::path file = folder_ / "results/small/records/tsvd.accuracy.json";
  json record = json::parse(read_text(file));
  record["rows"][0]["metrics"]["AR"]["mean"] = 0.0123;
  write_text(file, record.dump());
  const std::string said = run_again();
  EXPECT_NE(said.find("1 record made again: it has been changed since it was written"),
            std::string::npos)
      << said;
}

TEST(Generate, AListOfManyScenesIsADatasetToo) {
  const TemporaryFolder folder("many");
  json experiment = small_experiment();
  json scenes = json::array();
  for (int i = 0; i < 900; ++i) {
    const double x = -0.5 + i / 900.0;
    scenes.push_back({{"contacts",
                       {{{"shape", "disc"},
                         {"centre", {x, 0.25}},
                         {"radius", 0.2},
                         {"conductivity_ratio", 0.5}}}}});
  }
  experiment["datasets"]["test"]["scenes"] = scenes;
  experiment["datasets"]["test"].erase("count");
  write_text(folder / "small.json", experiment.dump());
  const Outcome outcome =
      run_program(folder.path(), "generate small.json --dataset test --out many.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const json recipe = json::parse(Hdf5File::open(folder / "many.h5").read_text_dataset("/recipe"));
  EXPECT_EQ(recipe.at("scenes").size(), 900u);
}

}  // namespace
}  // namespace ertbench
