#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/experiment/experiment_json.h"
#include "bench/features/features.h"
#include "core/errors.h"
#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using namespace testing;

json with(json content, const std::vector<std::string>& overrides) {
  apply_overrides(content, overrides);
  return content;
}

std::string override_refusal(const std::string& override) {
  try {
    with(good(), {override});
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Overrides, PutValuesIntoThePlacesThatTheirPathsName) {
  const json content = json::parse(R"({"a": {"b": [1, {"c.d": 2}]}, "e": "f"})");
  EXPECT_EQ(with(content, {"a.b.0=5"}).at("a").at("b").at(0), 5);
  EXPECT_EQ(with(content, {"/a/b/1/c.d=true"}).at("a").at("b").at(1).at("c.d"), true);
  EXPECT_EQ(with(content, {"e=g"}).at("e"), "g");
  EXPECT_EQ(with(content, {"e=\"7\""}).at("e"), "7");
  EXPECT_EQ(with(content, {R"(a={"h": [1]})"}).at("a"), json::parse(R"({"h": [1]})"));
  EXPECT_EQ(with(content, {"a.b=[1, 2]", "a.b.1=x=y"}).at("a").at("b"), json({1, "x=y"}));
  EXPECT_EQ(with(content, {"a.new=1"}).at("a").at("new"), 1);
  EXPECT_EQ(with(content, {"timing.enabled=false"}).at("timing").at("enabled"), false);
  EXPECT_EQ(with(content, {"a=null"}), json::parse(R"({"e": "f"})"));
  EXPECT_EQ(with(content, {"folds=null"}), content);
  EXPECT_TRUE(with(content, {"a.b.0=null"}).at("a").at("b").at(0).is_null());
}

TEST(Overrides, PathsThatLeadNowhereAreRefusedWithTheNearest) {
  EXPECT_EQ(override_refusal("datasets.test.count=5"), "");
  const auto expect = [](const std::string& override, const std::string& remedy) {
    const std::string message = override_refusal(override);
    EXPECT_EQ(message.rfind("--set " + override + ": ", 0), 0u) << message;
    EXPECT_NE(message.find(remedy), std::string::npos) << message;
  };
  expect("datasets.tset.count=5", "did you mean \"test\"?");
  expect("datasets.tset=5", "did you mean \"test\"?");
  expect("dataset.test.count=5", "did you mean \"datasets\"?");
  expect("solvers.9.rank=5", "a list of 3; name one of its values by its number");
  expect("solvers.tsvd.rank=5", "a list of 3");
  expect("title.size=5", "has nothing inside it");
  expect("title", "must be PATH=VALUE");
  expect("a..b=5", "empty word");
}

TEST(Overrides, AreCheckedAsTheFileIs) {
  const TemporaryFolder folder("overrides");
  json content = good();
  content["datasets"]["validation"].erase("grid");  // any sensor has it
  write_text(folder / "e.json", content.dump());
  SolverRegistry registry;
  const auto read = [&](const std::string& one) {
    return read_experiment(folder / "e.json", registry, chart_types(), SolverCheck::all, {one});
  };
  write_text(folder / "round.json", R"({"shape": "disc", "diameter_mm": 50, "drive": "opposite"})");
  EXPECT_EQ(read("sensor=round.json").sensor.sheet->size_mm().x(), 50);
  EXPECT_THROW(read("sensor=square.json"), InputError);
  const Experiment e = read("datasets.validation.count=7");
  EXPECT_EQ(e.validation->count, 7u);
  EXPECT_EQ(e.overrides, std::vector<std::string>{"datasets.validation.count=7"});
  try {
    read("datasets.validation.cuont=7");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean \"count\"?"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace ertbench
