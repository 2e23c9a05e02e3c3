#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/record/record_file.h"
#include "core/build.h"
#include "core/checksum.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using testing::TemporaryFolder;

const BuildStamp now{
    "0123456789ab", false, "program", {{"solver/x", {{1, 2, 3, 4, 5, 6, 7, 8}}}}, {}};

BuildStamp with(void (*change)(BuildStamp&)) {
  BuildStamp stamp = now;
  change(stamp);
  return stamp;
}

TEST(Reuse, NothingOfOtherProbes) {
  const BuildStamp other = with([](BuildStamp& s) {
    s.program = "other";
    s.probes["solver/x"].numbers[2] = -3;
  });
  for (const Reuse reuse : {Reuse::same_code, Reuse::same_program, Reuse::clean}) {
    EXPECT_NE(why_stale(other, now, reuse), "");
    EXPECT_NE(why_stale(std::nullopt, now, reuse), "");
    EXPECT_EQ(why_stale(now, now, reuse), "");
    EXPECT_EQ(reuse_from_name(name_of(reuse)), reuse);
  }
  const BuildStamp plugin = with([](BuildStamp& s) { s.plugins = {"one"}; });
  EXPECT_NE(why_stale(plugin, now, Reuse::same_code), "");
}

TEST(Reuse, AnotherProgramWithTheSameProbesWhereThatIsAllowed) {
  const BuildStamp rebuilt = with([](BuildStamp& s) { s.program = "other"; });
  EXPECT_EQ(why_stale(rebuilt, now, Reuse::same_code), "");
  EXPECT_NE(why_stale(rebuilt, now, Reuse::same_program), "");
  EXPECT_EQ(why_stale(rebuilt, now, Reuse::clean), "");
  const BuildStamp dirty = with([](BuildStamp& s) {
    s.program = "other";
    s.dirty = true;
  });
  EXPECT_EQ(why_stale(dirty, now, Reuse::same_code), "");
  EXPECT_NE(why_stale(dirty, now, Reuse::clean), "");
}

TEST(Reuse, AStampIsReadAsItWasWritten) {
  const BuildStamp stamp = stamp_of_this_build({{"scores", {{1, 2.5}}}});
  EXPECT_EQ(build_stamp_from_json(to_json(stamp)), stamp);
  EXPECT_EQ(stamp.program.size(), 32U);
  EXPECT_FALSE(build_stamp_from_json(nlohmann::json::object()).has_value());
}

/// What is in a record's place and cannot be taken is told, with the reason.
TEST(Reuse, ARecordSaysWhyItIsNotTaken) {
  const TemporaryFolder folder("records");
  const auto file = folder / "a.json";
  EXPECT_EQ(find_record(file, "key", now, Reuse::same_code).why_not, "");
  write_record(file, {{"x", 1}}, "key", now);
  EXPECT_TRUE(static_cast<bool>(find_record(file, "key", now, Reuse::same_code).record));
  EXPECT_EQ(find_record(file, "other", now, Reuse::same_code).why_not, "it is of other settings");
  testing::write_text(file, "{");
  const FoundRecord damaged = find_record(file, "key", now, Reuse::same_code);
  EXPECT_FALSE(static_cast<bool>(damaged.record));
  EXPECT_NE(damaged.why_not.find("cannot be read"), std::string::npos);
}

/// The whole way: records, fits and datasets say what made them, a second run takes them, what is
/// damaged is told and made again, and what another program made is made again where that is asked.
TEST(Provenance, FollowsEveryNumberFromTheRunToTheSummary) {
  const TemporaryFolder folder("provenance");
  testing::write_text(folder / "e.json", testing::small_experiment().dump());
  const auto first = testing::run_program(folder.path(), "run e.json --out r");
  ASSERT_EQ(first.exit_code, 0) << first.output;
  const nlohmann::json build =
      testing::row_of(testing::summary_of(folder / "r"), "tsvd").at("build");
  EXPECT_EQ(build.at("commit"), this_build().commit);
  EXPECT_EQ(build.at("dirty"), this_build().dirty);
  EXPECT_EQ(build.at("fitted").size(), 1U);
  EXPECT_EQ(build.at("fitted")[0].at("program"), build.at("program"));
  EXPECT_NE(testing::read_text(folder / "r/table.md").find("build: commit"), std::string::npos);

  const std::string record = (folder / "r/records/tsvd.accuracy.json").string();
  const std::string whole = testing::read_text(record);
  testing::write_text(record, whole.substr(0, 100));
  const auto damaged = testing::run_program(folder.path(), "run e.json --out r");
  EXPECT_NE(damaged.output.find("1 record made again: it cannot be read"), std::string::npos)
      << damaged.output;

  nlohmann::json other = nlohmann::json::parse(whole);
  other["build"]["program"] = "ffffffffffffffffffffffffffffffff";
  add_checksum(other);
  testing::write_text(record, other.dump());
  const auto reused = testing::run_program(folder.path(), "run e.json --out r");
  EXPECT_NE(reused.output.find("1 record reused of an earlier build"), std::string::npos)
      << reused.output;
  EXPECT_NE(testing::read_text(folder / "r/table.md").find("Made of records of 2 builds"),
            std::string::npos);
  const auto stale = testing::run_program(folder.path(), "run e.json --out r --rebuild-stale");
  EXPECT_NE(stale.output.find("1 record made again: it was made by another program"),
            std::string::npos)
      << stale.output;

  other["build"]["probes"]["solver/tsvd"][0] = 1e9;
  add_checksum(other);
  testing::write_text(record, other.dump());
  const auto code = testing::run_program(folder.path(), "run e.json --out r");
  EXPECT_NE(code.output.find("1 record made again: the probe solver/tsvd differs by"),
            std::string::npos)
      << code.output;
}

}  // namespace
}  // namespace ertbench
