// The published schema against the files that there are, and what it must refuse.

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment_json.h"
#include "core/json.h"
#include "solvers/check/checked_solver.h"
#include "tests/bench/experiment_testing.h"

namespace ertbench {
namespace {

using namespace testing;

std::vector<std::filesystem::path> published_experiments() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(experiments)) {
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") {
      files.push_back(entry.path());
    }
  }
  return files;
}

TEST(Experiment, EveryPublishedFileIsValid) {
  ASSERT_GE(published_experiments().size(), 6u);
  for (const auto& file : published_experiments()) {
    SCOPED_TRACE(file);
    EXPECT_EQ(schema_complaint(read_json_file(file)), "");
    EXPECT_EQ(schema_complaint(*read_experiment_json(file).content), "");
    const bool ktc = read_experiment_json(file).content->contains("data");
    EXPECT_EQ(refusal(file).empty(), !ktc) << refusal(file);
  }
}

// A sensor in an experiment and one in a file of its own are described by the same words.
TEST(Experiment, TheSchemaOfSensorFilesIsThatOfSensors) {
  const json files = read_json_file(experiments / "../sensors/schema.json");
  const json own = read_json_file(experiments / "schema.json");
  EXPECT_EQ(files.at("$ref"), "#/definitions/sensor");
  for (const auto& [name, definition] : files.at("definitions").items()) {
    EXPECT_EQ(definition, own.at("definitions").at(name)) << name;
  }
}

// `ertbench list --schema FILE` writes what they should be.
TEST(Experiment, SchemasHaveTheProgramsTypesRangesAndDefaults) {
  for (const char* name : {"schema.json", "../sensors/schema.json"}) {
    std::ifstream in(experiments / name);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    EXPECT_EQ(updated_schema(experiments / name), text) << name;
  }
}

// What experiments extend is not an experiment by itself, and keeps to the schema all the same.
TEST(Experiment, EveryBaseKeepsToTheSchema) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(experiments / "base")) {
    SCOPED_TRACE(entry.path());
    EXPECT_EQ(schema_complaint(read_json_file(entry.path())), "");
    ++files;
  }
  EXPECT_GE(files, 2);
}

TEST(Experiment, ReadmesExampleIsValid) {
  EXPECT_EQ(schema_complaint(read_json_file(ERTBENCH_PAGE_EXPERIMENT)), "");
  EXPECT_EQ(refusal(ERTBENCH_PAGE_EXPERIMENT), "");
}

TEST(Experiment, SchemaKnowsTheSameKeysOfFilesThatExtend) {
  const json schema = read_json_file(experiments / "schema.json");
  json keys = {"extends"};
  for (const auto& [key, unused] : schema.at("else").at("properties").items()) keys.push_back(key);
  json known = schema.at("then").at("propertyNames").at("enum");
  std::sort(keys.begin(), keys.end());
  std::sort(known.begin(), known.end());
  EXPECT_EQ(keys, known);
  EXPECT_NE(schema_complaint(json::parse(R"({"extends": "a.json", "titel": "t"})")), "");
  EXPECT_NE(schema_complaint(json::parse(R"({"extends": 5})")), "");
}

// Wherever the schema lists what a solver takes, it lists what every solver takes.
TEST(Experiment, ParametersOfEverySolverAreInTheSchema) {
  const json schema = read_json_file(experiments / "schema.json");
  int places = 0;
  const std::function<void(const json&)> visit = [&](const json& value) {
    if (value.is_object() && value.contains("checkpoint") && value.contains("type")) {
      ++places;
      for (const ParameterInfo& parameter : CheckedSolver::own_parameters()) {
        EXPECT_TRUE(value.contains(parameter.name)) << parameter.name << " in " << value;
      }
    }
    if (value.is_structured()) {
      for (const json& part : value) visit(part);
    }
  };
  visit(schema);
  EXPECT_GE(places, 10);
}

TEST(Experiment, ParametersOfNetworksAreInTheSchema) {
  const auto complaint = [](const json& entry) {
    json value = good();
    value["solvers"].push_back(entry);
    return schema_complaint(value);
  };
  EXPECT_EQ(complaint({{"type", "dd-ert"},
                       {"seeds", {1, 2}},
                       {"epochs", 20},
                       {"attention", false},
                       {"initialisation", "lmmse"},
                       {"attention_form", "self"},
                       {"content_loss", "relative"},
                       {"sweep", {{"alpha", {0, 1e-3}}, {"beta", {0.1}}}}}),
            "");
  EXPECT_EQ(complaint({{"type", "fcnn"}, {"loss", "relative"}, {"widths", {2304, 576}}}), "");
  EXPECT_EQ(complaint({{"type", "eit-nn"}, {"sensitivity_lambda", "auto"}, {"channels", {32, 64}}}),
            "");
  EXPECT_EQ(complaint({{"type", "dcnn"}, {"widths", {64, 128, 256}}, {"schedule", "constant"}}),
            "");
  EXPECT_EQ(complaint({{"type", "lean-net"}, {"loss", "mse"}, {"sweep", {{"width", {8, 32}}}}}),
            "");
  for (const json& wrong :
       {json{{"type", "dd-ert"}, {"alpha", -1}}, json{{"type", "dd-ert"}, {"batch", 1}},
        json{{"type", "dd-ert"}, {"widths", {1}}}, json{{"type", "fcnn"}, {"epochs", 0}},
        json{{"type", "dcnn"}, {"widths", {64, 128}}}, json{{"type", "eit-nn"}, {"loss", "l1"}},
        json{{"type", "lean-net"}, {"bottom_blocks", -1}}}) {
    EXPECT_NE(complaint(wrong), "") << wrong;
  }
}

}  // namespace
}  // namespace ertbench
