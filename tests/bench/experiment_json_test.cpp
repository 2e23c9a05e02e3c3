#include "bench/experiment/experiment_json.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::TemporaryFolder;
using testing::write_text;

json content(const fs::path& file) { return *read_experiment_json(file).content; }

std::string refusal_of(const fs::path& file) {
  try {
    read_experiment_json(file);
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

class ExperimentJsonFiles : public ::testing::Test {
 protected:
  fs::path write(const char* name, const char* text) {
    fs::create_directories((folder_ / name).parent_path());
    write_text(folder_ / name, text);
    return folder_ / name;
  }

  const TemporaryFolder folder_{"experiment_json"};
};

TEST_F(ExperimentJsonFiles, WithoutExtendsIsWhatStandsThere) {
  const fs::path file = write("a.json", R"({"title": "t", "figure": null})");
  const ExperimentJson read = read_experiment_json(file);
  EXPECT_EQ(*read.content, json({{"title", "t"}, {"figure", nullptr}}));
  EXPECT_EQ(read.source, file.string());
  EXPECT_EQ(read.files, std::vector{file});
}

/// The rules of RFC 7386, each once.
TEST_F(ExperimentJsonFiles, AreMergedByTheRulesOfMergePatch) {
  write("base.json", R"({"a": "b", "c": {"d": "e", "f": "g"}, "list": [1, 2, 3], "x": 1})");
  const fs::path file = write("more.json", R"({"extends": "base.json", "a": "z",
      "c": {"f": null, "h": {"i": null}}, "list": [4], "x": {"y": 2}, "new": true})");
  EXPECT_EQ(content(file), json::parse(R"({"a": "z", "c": {"d": "e", "h": {}}, "list": [4],
                                           "x": {"y": 2}, "new": true})"));
  EXPECT_EQ(read_experiment_json(file).source, file.string() + " (extends base.json)");
}

TEST_F(ExperimentJsonFiles, NamesAreRelativeToTheFileThatSaysThem) {
  write("shared/base.json", R"({"extends": "../root.json", "b": 2})");
  write("root.json", R"({"a": 1, "b": 1, "c": 1})");
  const fs::path file = write("mine/more.json", R"({"extends": "../shared/base.json", "c": 3})");
  EXPECT_EQ(content(file), json({{"a", 1}, {"b", 2}, {"c", 3}}));
  const ExperimentJson read = read_experiment_json(file);
  EXPECT_EQ(read.files.size(), 3u);
  EXPECT_EQ(read.source, file.string() + " (extends ../shared/base.json, ../root.json)");
  const fs::path absolute = write("absolute.json", json{{"extends", file.string()}}.dump().c_str());
  EXPECT_EQ(content(absolute), content(file));
}

TEST_F(ExperimentJsonFiles, WhatCannotBeExtendedIsRefusedWithItsPlace) {
  const fs::path file = write("a.json", R"({"extends": "absent.json"})");
  EXPECT_EQ(refusal_of(file), file.string() + ": /extends: " + (folder_ / "absent.json").string() +
                                  ": cannot be opened: there is no such file; check the name");
  write("shared_base.json", "{}");
  EXPECT_EQ(refusal_of(folder_ / "shraed_base.json"),
            (folder_ / "shraed_base.json").string() +
                ": cannot be opened: there is no such file; did you mean " +
                (folder_ / "shared_base.json").string() + "?");
  write("a.json", R"({"extends": ["b.json"]})");
  EXPECT_EQ(refusal_of(file),
            file.string() + R"(: /extends: must be a string that is not empty, got ["b.json"])");
  write("b.json", "[1]");
  write("a.json", R"({"extends": "b.json"})");
  EXPECT_EQ(refusal_of(file), file.string() + ": /extends: " + (folder_ / "b.json").string() +
                                  " is not an experiment");
  write("b.json", "{");
  EXPECT_EQ(
      refusal_of(file).rfind(file.string() + ": /extends: " + (folder_ / "b.json").string(), 0),
      0u);
}

TEST_F(ExperimentJsonFiles, CirclesAreRefused) {
  const fs::path self = write("self.json", R"({"extends": "./self.json"})");
  EXPECT_NE(refusal_of(self).find("/extends: goes in a circle"), std::string::npos)
      << refusal_of(self);
  write("a.json", R"({"extends": "b.json"})");
  write("b.json", R"({"extends": "c.json"})");
  const fs::path last = write("c.json", R"({"extends": "folder/../b.json"})");
  fs::create_directory(folder_ / "folder");
  const std::string message = refusal_of(folder_ / "a.json");
  EXPECT_NE(message.find("c.json: /extends: goes in a circle"), std::string::npos) << message;
}

TEST_F(ExperimentJsonFiles, ChainsHaveAnEnd) {
  write("e0.json", R"({"title": "t"})");
  write("e1.json", R"({"extends": "e0.json"})");
  write("e2.json", R"({"extends": "e1.json"})");
  write("e3.json", R"({"extends": "e2.json"})");
  write("e4.json", R"({"extends": "e3.json"})");
  write("e5.json", R"({"extends": "e4.json"})");
  EXPECT_EQ(content(folder_ / "e4.json"), json({{"title", "t"}}));
  EXPECT_NE(
      refusal_of(folder_ / "e5.json").find("e1.json: /extends: is one too many: at most 4 files"),
      std::string::npos)
      << refusal_of(folder_ / "e5.json");
}

}  // namespace
}  // namespace ertbench
