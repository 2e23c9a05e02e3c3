#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "bench/features/features.h"
#include "core/errors.h"
#include "solvers/registry/registry.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// A skin, a set of touches at places and one of written characters.
json touch_experiment() {
  const json noise = {{"snr_db", 50}, {"snr_basis", "absolute"}};
  json places = noise;
  places["scenes"] = {{"touches", 1},
                      {"indenters", {{{"type", "flat"}}}},
                      {"force_N", 5},
                      {"places", {{"grid", {3, 3}}}}};
  json writing = noise;
  writing["scenes"] = {{"sequence", "write"}, {"characters", "L"}};
  return {{"title", "t"},
          {"question", "q"},
          {"sensor", {{"skin", {{"law", {{"type", "rising"}}}}}}},
          {"datasets", {{"places", places}, {"writing", writing}}},
          {"solvers", {{{"type", "tsvd"}, {"rank", 20}}}},
          {"studies", {{{"type", "localisation"}, {"sets", {"places"}}}}}};
}

Experiment study_of(const json& value) {
  const testing::TemporaryFolder folder;
  testing::write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  return read_experiment(folder / "e.json", registry, chart_types());
}

std::string study_refusal(const json& value) {
  try {
    study_of(value);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(StudySpec, IsReadWithItsDefaults) {
  const Experiment experiment = study_of(touch_experiment());
  ASSERT_EQ(experiment.studies.size(), 1u);
  EXPECT_EQ(experiment.studies[0].name, "localisation");
  EXPECT_EQ(experiment.studies[0].maps, std::vector<std::string>{"places"});
  EXPECT_TRUE(experiment.keep_contacts);
  EXPECT_STREQ(name_of(experiment.sensor.skin->law), "rising");
}

TEST(StudySpec, RefusesSetsOfAnotherKind) {
  json value = touch_experiment();
  value["studies"][0]["sets"] = {"writing"};
  EXPECT_NE(study_refusal(value).find("/studies/0/sets"), std::string::npos)
      << study_refusal(value);
  value["studies"][0] = {{"type", "tracking"}, {"sets", {"writing"}}};
  EXPECT_EQ(study_refusal(value), "");
  value["studies"][0] = {{"type", "collision"}, {"quiet", "writing"}};
  EXPECT_NE(study_refusal(value), "");
  value["studies"][0] = {{"type", "tracking"}, {"sets", {"absent"}}};
  EXPECT_NE(study_refusal(value), "");
}

TEST(StudySpec, TouchesNeedASkinAndAGrid) {
  json value = touch_experiment();
  value["datasets"]["places"]["grid"] = "auto";
  EXPECT_NE(study_refusal(value).find("/datasets/places/grid"), std::string::npos)
      << study_refusal(value);
  value = touch_experiment();
  value.erase("sensor");
  EXPECT_NE(study_refusal(value).find("skin"), std::string::npos) << study_refusal(value);
}

}  // namespace
}  // namespace ertbench
