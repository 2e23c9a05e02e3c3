#include "bench/experiment/experiment.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/features/features.h"
#include "bench/record/cache.h"
#include "bench/record/measurement_records.h"
#include "core/errors.h"
#include "forward/fem/forward_model.h"
#include "forward/sheet/sensor_json.h"
#include "solvers/registry/registry.h"
#include "tests/bench/experiment_testing.h"
#include "tests/bench/program.h"
#include "tests/under_sanitizers.h"

namespace ertbench {
namespace {

using namespace testing;

TEST(Experiment, TablesNameTheSameTrainingSetAndScenes) {
  SolverRegistry registry;
  const Experiment c1 =
      read_experiment(experiments / "table_c1_broad.json", registry, chart_types());
  const Experiment fine =
      read_experiment(experiments / "table_c1_fine.json", registry, chart_types());
  const Experiment literal =
      read_experiment(experiments / "table_c1_literal.json", registry, chart_types());
  const Cache cache("c");
  EXPECT_EQ(cache.dataset(*c1.training), cache.dataset(*fine.training));
  EXPECT_EQ(cache.dataset(*c1.training), cache.dataset(*literal.training));
  for (const char* name : {"ablation.json", "grid_alpha_beta.json"}) {
    const Experiment other = read_experiment(experiments / name, registry, chart_types());
    EXPECT_EQ(cache.dataset(*c1.training), cache.dataset(*other.training)) << name;
    EXPECT_EQ(cache.dataset(*c1.validation), cache.dataset(*other.validation)) << name;
    EXPECT_EQ(cache.dataset(c1.tests[0]), cache.dataset(other.tests[0])) << name;
  }
  EXPECT_NE(cache.dataset(c1.tests[0]), cache.dataset(fine.tests[0]));
  for (std::size_t s = 0; s < c1.solvers.size(); ++s) {
    EXPECT_EQ(cache.fitted_solver(fit_recipe(c1, c1.solvers[s])),
              cache.fitted_solver(fit_recipe(fine, fine.solvers[s])));
  }
  // The fine scenes are those of Table C1, on another grid.
  for (const std::uint64_t index : {0u, 17u, 999u}) {
    EXPECT_EQ(to_json(c1.tests[0].scene(index)), to_json(fine.tests[0].scene(index)));
  }
}

TEST(Experiment, FineGridIsWithinAQuarterOfTheNoise) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  SolverRegistry registry;
  const DatasetSpec set =
      read_experiment(experiments / "table_c1_fine.json", registry, chart_types()).tests.front();
  const int grid = std::get<GridSheet>(set.model).side;
  const auto change_on = [&](int side, const Scene& scene) {
    const ForwardModel model(set.sensor, side);
    Eigen::VectorXd ratio(side * side);
    rasterise(scene, square_sheet()->pixels(side), Rasterisation::area, ratio);
    const Frames voltages = model.solve(set.sensor.background * ratio.transpose());
    return Eigen::VectorXd(voltages.row(0).transpose() - model.reference_voltages());
  };
  const double noise = std::pow(10, -*set.noise.snr_db / 20) *
                       ForwardModel(set.sensor, grid).reference_voltages().norm();
  // Cut pixels make the error first order in the pixel's side: what is left on this grid is about
  // twice what changes on the next one.
  double largest = 0;
  for (std::uint64_t index = 0; index < 12; ++index) {
    const Scene scene = set.scene(index);
    const double difference = (change_on(grid, scene) - change_on(2 * grid, scene)).norm();
    EXPECT_LT(2 * difference, noise / 4) << "scene " << index;
    largest = std::max(largest, difference);
  }
  EXPECT_GT(largest, 0);
}

TEST(Experiment, InMillimetresIsTheSameExperiment) {
  const TemporaryFolder folder("millimetres");
  json value = good();
  value["datasets"]["validation"]["scenes"] = json::parse(
      R"({"contacts": [1, 3], "radius_mm": [10, 30], "centre": {"x_mm": [-20, 20], "y_mm": 0}})");
  value["datasets"]["test"]["scenes"][0]["contacts"] = json::parse(R"([
      {"shape": "disc", "centre_mm": [10, 0], "radius_mm": 20, "conductivity_ratio": 0.6},
      {"shape": "ellipse", "centre_mm": [0, 0], "semi_axes_mm": [8, 10], "conductivity_ratio": 0.6},
      {"shape": "polygon", "vertices_mm": [[0, 0], [5, 0], [0, 5]], "conductivity_ratio": 0.6}])");
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "mm.json", value.dump());
  value["datasets"]["validation"]["scenes"] = json::parse(
      R"({"contacts": [1, 3], "radius": [0.1, 0.3], "centre": {"x": [-0.2, 0.2], "y": 0}})");
  value["datasets"]["test"]["scenes"][0]["contacts"] = json::parse(R"([
      {"shape": "disc", "centre": [0.1, 0], "radius": 0.2, "conductivity_ratio": 0.6},
      {"shape": "ellipse", "centre": [0, 0], "semi_axes": [0.08, 0.1], "conductivity_ratio": 0.6},
      {"shape": "polygon", "vertices": [[0, 0], [0.05, 0], [0, 0.05]], "conductivity_ratio": 0.6}])");
  write_text(folder / "domain.json", value.dump());
  SolverRegistry registry;
  const Cache cache("c");
  const Experiment mm = read_experiment(folder / "mm.json", registry, chart_types());
  const Experiment domain = read_experiment(folder / "domain.json", registry, chart_types());
  EXPECT_EQ(cache.dataset(*mm.validation), cache.dataset(*domain.validation));
  EXPECT_EQ(cache.dataset(mm.tests[0]), cache.dataset(domain.tests[0]));
}

TEST(Experiment, OneThatExtendsAnotherIsReadAsTheMergedOne) {
  const TemporaryFolder folder("extending");
  write_text(folder / "base.json", good().dump());
  const json more = json::parse(R"({"extends": "base.json", "title": "noisy", "figure": null,
      "datasets": {"validation": {"snr_db": 60}}, "solvers": [{"type": "tsvd", "rank": 30}]})");
  EXPECT_EQ(schema_complaint(more), "");
  write_text(folder / "noisy.json", more.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "noisy.json", registry, chart_types());
  EXPECT_EQ(e.name, "noisy");
  EXPECT_EQ(e.title, "noisy");
  EXPECT_EQ(e.question, "q");
  EXPECT_EQ(e.validation->noise.snr_db, 60);
  EXPECT_EQ(e.validation->count, 10u);
  EXPECT_EQ(e.solvers.size(), 1u);

  json wrong = more;
  wrong["solvers"][0]["rank"] = 0;
  write_text(folder / "noisy.json", wrong.dump());
  const std::string place = (folder / "noisy.json").string() + " (extends base.json): ";
  EXPECT_EQ(refusal(folder / "noisy.json").rfind(place + "/solvers/0/rank: must be", 0), 0u)
      << refusal(folder / "noisy.json");
  wrong["solvers"] = nullptr;
  write_text(folder / "noisy.json", wrong.dump());
  EXPECT_EQ(refusal(folder / "noisy.json"), place + "/solvers: is missing");
}

TEST(Experiment, ASensorThatHasAFileReplacesTheExtendedOne) {
  const TemporaryFolder folder("sensors");
  json below = good();
  below["datasets"]["validation"].erase("grid");
  below["sensor"] = {{"shape", "disc"},
                     {"diameter_mm", 50},
                     {"electrode_model", "gap"},
                     {"electrode_width", 0.2},
                     {"background", 0.01}};
  write_text(folder / "below.json", below.dump());
  write_text(folder / "round.json",
             R"({"shape": "disc", "diameter_mm": 80, "drive": {"skip": 2}})");
  const auto sensor_of = [&](const json& sensor) {
    write_text(folder / "e.json", json{{"extends", "below.json"}, {"sensor", sensor}}.dump());
    SolverRegistry registry;
    return to_json(read_experiment(folder / "e.json", registry, chart_types()).sensor);
  };
  EXPECT_EQ(sensor_of("round.json"), to_json(read_sensor(folder / "round.json")));
  json changed = below.at("sensor");
  changed["background"] = 0.02;
  EXPECT_EQ(sensor_of({{"background", 0.02}}),
            to_json(sensor_from_json(JsonObject(changed, "", ""))));
}

TEST(Experiment, SoManyScenesOfTheFigureAreTakenEvenly) {
  const TemporaryFolder folder("figure");
  json content = good();
  content["datasets"]["test"] = content["datasets"]["validation"];
  content["datasets"]["test"]["count"] = 101;
  const auto scenes = [&](const json& wanted) {
    content["figure"] = {{"scenes", wanted}};
    write_text(folder / "e.json", content.dump());
    SolverRegistry registry;
    return read_experiment(folder / "e.json", registry, chart_types()).figure_scenes;
  };
  EXPECT_EQ(scenes(3), (std::vector<int>{0, 50, 100}));
  EXPECT_EQ(scenes(1), (std::vector<int>{0}));
  EXPECT_EQ(scenes({7, 3}), (std::vector<int>{7, 3}));
  content["datasets"]["test"]["count"] = 2;
  EXPECT_EQ(scenes(8), (std::vector<int>{0, 1}));
  EXPECT_THROW(scenes(13), InputError);
}

TEST(Experiment, ContactsAreReadAsTheFileSays) {
  const TemporaryFolder folder("contacts");
  json value = good();
  SolverRegistry registry;
  const auto read = [&] {
    write_text(folder / "e.json", value.dump());
    return read_experiment(folder / "e.json", registry, chart_types());
  };
  const Experiment plain = read();
  EXPECT_EQ(plain.contacts, ContactSettings{});
  EXPECT_FALSE(plain.keep_contacts);
  value["contacts"] = {{"threshold", 0.4}, {"floor", "auto"}, {"saddle", 0.5}, {"match_mm", 12}};
  const Experiment given = read();
  EXPECT_EQ(given.contacts, (ContactSettings{0.4, std::nullopt, "", 0.5, 12, std::nullopt}));

  const auto key = [](Experiment e, bool keep) {
    e.keep_contacts = keep;
    return accuracy_key(e, e.solvers[0]);
  };
  EXPECT_NE(key(plain, false), key(given, false));
  value["contacts"]["chosen_on"] = "test";
  const Experiment elsewhere = read();
  EXPECT_EQ(elsewhere.contacts.chosen_on, "test");
  EXPECT_NE(key(elsewhere, false), key(given, false));
  value["contacts"]["chosen_on"] = "train";
  EXPECT_THROW(read(), InputError);
  EXPECT_NE(key(plain, false), key(plain, true));
}

}  // namespace
}  // namespace ertbench
