#include "bench/experiment/experiment.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/charts/chart_types.h"
#include "bench/charts/speed_chart.h"
#include "bench/experiment/experiment_json.h"
#include "bench/record/accuracy_record.h"
#include "bench/record/cache.h"
#include "core/errors.h"
#include "core/json_reader.h"
#include "forward/fem/forward_model.h"
#include "solvers/registry/registry.h"
#include "tests/bench/line_process.h"
#include "tests/bench/program.h"
#include "tests/under_sanitizers.h"

namespace ertbench {
namespace {

using nlohmann::json;
using testing::TemporaryFolder;
using testing::write_text;

const std::filesystem::path experiments = ERTBENCH_SOURCE_DIR "/experiments";

std::vector<std::filesystem::path> published_experiments() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(experiments)) {
    if (entry.path().extension() == ".json" && entry.path().filename() != "schema.json") {
      files.push_back(entry.path());
    }
  }
  return files;
}

/// The published schema's validator, which lives as long as the tests.
std::string schema_complaint(const json& value) {
  static testing::LineProcess validator({"/usr/bin/python3",
                                         ERTBENCH_SOURCE_DIR "/tests/bench/validate_schema.py",
                                         (experiments / "schema.json").string()});
  return validator.answer(value.dump());
}

std::string refusal(const std::filesystem::path& file) {
  SolverRegistry registry;
  try {
    read_experiment(file, registry, chart_types());
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Experiment, EveryPublishedFileIsValid) {
  ASSERT_GE(published_experiments().size(), 6u);
  for (const auto& file : published_experiments()) {
    SCOPED_TRACE(file);
    EXPECT_EQ(schema_complaint(read_json_file(file)), "");
    EXPECT_EQ(schema_complaint(*read_experiment_json(file).content), "");
    EXPECT_EQ(refusal(file), "");
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

/// A small experiment that is right.
json good() {
  return json::parse(R"({
    "title": "t", "question": "q",
    "sensor": {"electrode_count": 16},
    "datasets": {
      "validation": {"count": 10, "seed": 2, "grid": 24, "snr_db": 50, "snr_basis": "absolute",
                     "scenes": {"contacts": [1, 3], "radius": [0.1, 0.3]}},
      "test": {"snr_db": null, "scenes": [{"contacts": [
          {"shape": "disc", "centre": [0, 0], "radius": 0.2, "conductivity_ratio": 0.6}]}]}
    },
    "solvers": [{"type": "tsvd", "rank": 20}, {"type": "one-step-gn", "lambda": "auto"},
                {"type": "pdipm", "alpha": 1e-4}],
    "timing": {"frames": 700, "batch": 16},
    "figure": {"scenes": [0]},
    "published": {"source": "s", "rows": {"tsvd": {"AR": 1.2}}}
  })");
}

struct Broken {
  const char* place;   ///< JSON pointer of what is changed
  const char* value;   ///< the new JSON, or "remove"
  const char* path;    ///< that the message must name
  const char* remedy;  ///< that it must contain
  bool schema_can_tell = true;
};

const Broken broken[] = {
    {"/solvers/1/lambda", "-1", "/solvers/1/lambda", "must be > 0"},
    {"/solvers/1/lambda", "0", "/solvers/1/lambda", "must be > 0"},
    {"/solvers/1/lambda", "\"best\"", "/solvers/1/lambda", "auto"},
    {"/solvers/1/lambda", "[1]", "/solvers/1/lambda", "auto"},
    {"/solvers/1/lamda", "1", "/solvers/1/lamda", "did you mean \"lambda\""},
    {"/solvers/1/prior", "\"total variation\"", "/solvers/1/prior", "\"tikhonov\""},
    {"/solvers/0/rank", "0", "/solvers/0/rank", "1"},
    {"/solvers/0/rank", "105", "/solvers/0/rank", "104", false},
    {"/solvers/0/rank", "2.5", "/solvers/0/rank", "whole"},
    {"/solvers/0/threshold", "0.1", "/solvers/0", "rank"},
    {"/solvers/2/alpha", "-1e-4", "/solvers/2/alpha", "must be > 0"},
    {"/solvers/2/max_iterations", "0", "/solvers/2/max_iterations", "from 1 to"},
    {"/solvers/0/type", "\"tsdv\"", "/solvers/0/type", "tsvd", false},
    {"/solvers/0/type", "7", "/solvers/0/type", "string"},
    {"/solvers/0/type", "remove", "/solvers/0/type", "missing"},
    {"/solvers/0/label", "\"../../etc\"", "/solvers/0/label", "letters"},
    {"/solvers/0/label", "\"pdipm\"", "/solvers/2/label", "taken", false},
    {"/solvers/0/label", "\"truth\"", "/solvers/0/label", "taken", false},
    {"/solvers", "[]", "/solvers", "at least one"},
    {"/solvers", "{}", "/solvers", "array"},
    {"/solvers", "remove", "/solvers", "missing"},
    {"/solvers/0", "\"tsvd\"", "/solvers/0", "object"},
    {"/datasets", "remove", "/datasets", "missing"},
    {"/datasets", "{}", "/datasets", "test set"},
    {"/datasets/test", "remove", "/datasets", "test set", false},
    {"/datasets/validation", "remove", "/solvers/1", "validation", false},
    {"/datasets/a b", "{}", "/datasets/a b", "letters"},
    {"/datasets/test/snr_db", "remove", "/datasets/test/snr_db", "missing"},
    {"/datasets/test/snr_db", "\"50\"", "/datasets/test/snr_db", "null"},
    {"/datasets/test/count", "7", "/datasets/test/count", "1", false},
    {"/datasets/validation/snr_basis", "remove", "/datasets/validation/snr_basis", "missing"},
    {"/datasets/validation/snr_basis", "\"relative\"", "/datasets/validation/snr_basis",
     "\"difference\""},
    {"/datasets/validation/count", "0", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "-5", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "1e300", "/datasets/validation/count", "from 1 to"},
    {"/datasets/validation/count", "remove", "/datasets/validation/count", "missing", false},
    {"/datasets/validation/grid", "30", "/datasets/validation/grid", "power of two", false},
    {"/datasets/validation/grid", "12", "/datasets/validation/grid", "power of two", false},
    {"/datasets/validation/grid", "1000000", "/datasets/validation/grid", "from 1 to"},
    {"/datasets/validation/rasterisation", "\"exact\"", "/datasets/validation/rasterisation",
     "\"centre\""},
    {"/datasets/validation/seed", "-1", "/datasets/validation/seed", "from 0"},
    {"/datasets/validation/scenes", "5", "/datasets/validation/scenes", "object"},
    {"/datasets/validation/scenes", "[]", "/datasets/validation/scenes", "at least one"},
    {"/datasets/validation/scenes/radius", "[0.3, 0.1]", "/datasets/validation/scenes/radius",
     "low <= high", false},
    {"/datasets/validation/scenes/radius", "[0.1, 0.2, 0.3]", "/datasets/validation/scenes/radius",
     "2 numbers"},
    {"/datasets/validation/scenes/radius", "-0.1", "/datasets/validation/scenes/radius",
     "from 1e-06 to 2"},
    {"/datasets/validation/scenes/contacts", "[1.5, 2]", "/datasets/validation/scenes/contacts",
     "whole"},
    {"/datasets/validation/scenes/shapes", "[\"circle\"]", "/datasets/validation/scenes/shapes/0",
     "\"disc\""},
    {"/datasets/validation/scenes/shapes", "[]", "/datasets/validation/scenes/shapes", "disc"},
    {"/datasets/validation/scenes/blank_fraction", "2",
     "/datasets/validation/scenes/blank_fraction", "from 0 to 1"},
    {"/datasets/validation/scenes/conductivity", "0.5", "/datasets/validation/scenes/conductivity",
     "did you mean \"conductivity_ratio\""},
    {"/datasets/test/scenes/0/contacts/0/radius", "remove",
     "/datasets/test/scenes/0/contacts/0/radius", "missing"},
    {"/datasets/test/scenes/0/contacts/0/centre", "[0]",
     "/datasets/test/scenes/0/contacts/0/centre", "2 numbers"},
    {"/datasets/test/scenes/0/contacts/0/shape", "\"ring\"",
     "/datasets/test/scenes/0/contacts/0/shape", "\"polygon\""},
    {"/datasets/test/scenes/0/contacts/0/conductivity_ratio", "0",
     "/datasets/test/scenes/0/contacts/0/conductivity_ratio", "from 1e-06 to 1000"},
    {"/datasets/test/scenes/0/contacts/0/semi_axes", "[1, 1]",
     "/datasets/test/scenes/0/contacts/0/semi_axes", "unknown key"},
    {"/datasets/test/scenes/0/contacts",
     "[{\"shape\": \"polygon\", \"conductivity_ratio\": 0.5, "
     "\"vertices\": [[0, 0], [1, 1], [1, 0], [0, 1]]}]",
     "/datasets/test/scenes/0/contacts/0/vertices", "cross", false},
    {"/datasets/test/scenes/0/contacts",
     "[{\"shape\": \"polygon\", \"conductivity_ratio\": 0.5, "
     "\"vertices\": [[0, 0], [1, 1]]}]",
     "/datasets/test/scenes/0/contacts/0/vertices", "3 to 64"},
    {"/datasets/test/scenes/0/contacts/0/radius_mm", "20",
     "/datasets/test/scenes/0/contacts/0/radius_mm", "stands beside \"radius\""},
    {"/datasets/test/scenes/0/contacts/0/centre_mm", "[0, 0]",
     "/datasets/test/scenes/0/contacts/0/centre_mm", "remove one"},
    {"/datasets/validation/scenes/radius_mm", "20", "/datasets/validation/scenes/radius_mm",
     "stands beside \"radius\""},
    {"/datasets/validation/scenes/centre", R"({"x_mm": 0})", "/datasets/validation/scenes/centre/y",
     "missing"},
    {"/datasets/validation/scenes/centre", R"({"x_mm": "left", "y": 0})",
     "/datasets/validation/scenes/centre/x_mm", "2 numbers"},
    {"/sensor/electrode_count", "17", "/sensor", "falls between", false},
    {"/sensor/electrode_count", "3", "/sensor/electrode_count", "from 5"},
    {"/sensor/electrode_offset", "0.1", "/sensor", "falls between", false},
    {"/sensor/electrode_offset", "0.5", "/sensor/electrode_offset", "less than", false},
    {"/sensor/background", "0", "/sensor/background", "must be from 1e-09 to 1e+08 S/m, got 0"},
    {"/sensor/background", "1e200", "/sensor/background", "to 1e+08 S/m, got 1e+200"},
    {"/sensor/background", "1e-200", "/sensor/background", "from 1e-09"},
    {"/sensor/drive_current", "\"25 mA\"", "/sensor/drive_current", "from 1e-09 to 100 A"},
    {"/sensor/drive_current", "1e200", "/sensor/drive_current", "to 100 A"},
    {"/sensor/drive_current", "1e-200", "/sensor/drive_current", "from 1e-09"},
    {"/solvers/1/lambda", "1e200", "/solvers/1/lambda", "must be from 1e-20 to 1e+20 or \"auto\""},
    {"/solvers/1/lambda", "1e-200", "/solvers/1/lambda", "from 1e-20"},
    {"/solvers/2/alpha", "1e-200", "/solvers/2/alpha", "from 1e-20"},
    {"/datasets/validation/scenes/radius", "1e-200", "/datasets/validation/scenes/radius",
     "from 1e-06 to 2"},
    {"/datasets/validation/scenes/aspect", "1e-200", "/datasets/validation/scenes/aspect",
     "from 0.001 to 1"},
    {"/datasets/validation/scenes/conductivity_ratio", "[1e-200, 1]",
     "/datasets/validation/scenes/conductivity_ratio", "from 1e-06 to 1000"},
    {"/datasets/test/scenes/0/contacts/0/radius", "1e-200",
     "/datasets/test/scenes/0/contacts/0/radius", "from 1e-06 to 100"},
    {"/published/rows/tsvd/AR", "1e308", "/published/rows/tsvd/AR", "from -1e+06 to 1e+06"},
    {"/sensor/electrodes", "16", "/sensor/electrodes", "did you mean"},
    {"/timing/frames", "100", "/timing/frames", "from 662"},
    {"/timing/rounds", "0", "/timing/rounds", "from 1"},
    {"/check", R"({"seeds": 0})", "/check/seeds", "from 1"},
    {"/check", R"({"baseline_seeds": 2})", "/check/baseline_seeds", "from 3"},
    {"/check", R"({"seed": 2})", "/check/seed", "did you mean"},
    {"/contacts", R"({"threshold": 1.5})", "/contacts/threshold", "from 0 to 1"},
    {"/contacts", R"({"threshold": "best"})", "/contacts/threshold", "auto"},
    {"/contacts", R"({"floor": -1})", "/contacts/floor", "\"auto\""},
    {"/contacts", R"({"saddle": "auto"})", "/contacts/saddle", "from 0 to 1"},
    {"/contacts", R"({"match_mm": 0})", "/contacts/match_mm", "> 0"},
    {"/contacts", R"({"ospa": 50})", "/contacts/ospa", "did you mean \"ospa_mm\""},
    {"/right_sizing", R"({"margin": -0.1})", "/right_sizing/margin", "from 0 to 10"},
    {"/right_sizing", R"({"metric": "AR"})", "/right_sizing/metric", "\"PE\"", false},
    {"/right_sizing", R"({"margins": 0.1})", "/right_sizing/margins", "did you mean"},
    {"/solvers/0/family", R"("a/b")", "/solvers/0/family", "label"},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "metric": "AR"}])", "/charts/0/metric",
     "\"relative_error\"", false},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "budgets_us": [0]}])",
     "/charts/0/budgets_us", "> 0"},
    {"/charts", R"([{"type": "speed-accuracy", "name": "a", "break_even_against": ["gn"]}])",
     "/charts/0/break_even_against/0", "\"one-step-gn\"", false},
    {"/charts", R"([{"type": "training-budget", "name": "a", "metric": "AR"}])", "/charts/0/metric",
     "\"relative_error\"", false},
    {"/charts", R"([{"type": "training-budget", "name": "a", "cost": "money"}])", "/charts/0/cost",
     "\"scenes\""},
    {"/timing/enabled", "1", "/timing/enabled", "true or false"},
    {"/time_limit_s", "0", "/time_limit_s", "> 0"},
    {"/figure/scenes", "[1]", "/figure/scenes", "from 0 to 0", false},
    {"/figure/scenes", "[-1]", "/figure/scenes", "from 0 to 0"},
    {"/published/rows/tsvd/ar", "1", "/published/rows/tsvd/ar", "did you mean \"AR\"", false},
    {"/published/datasets", "[\"train\"]", "/published/datasets", "test sets", false},
    {"/plugins", "[\"absent.so\"]", "/plugins", "absent.so", false},
    {"/plugins", "\"absent.so\"", "/plugins", "list"},
    {"/titel", "\"x\"", "/titel", "did you mean \"title\""},
    {"/solvers/0/seeds", "[1, 2]", "/solvers/0/seeds", "tsvd has no training seed; remove it"},
    {"/solvers/1/sweep", "5", "/solvers/1/sweep", "object"},
    {"/solvers/1/sweep", "{}", "/solvers/1/sweep", "one or two"},
    {"/solvers/1/sweep", R"({"a": [1], "b": [1], "c": [1]})", "/solvers/1/sweep", "one or two"},
    {"/solvers/1/sweep", R"({"prior": ["noser", "tikonov"]})", "/solvers/1/sweep/prior/1",
     "\"tikhonov\"", false},
    {"/solvers/1/sweep", R"({"lambda": [0.1, 1]})", "/solvers/1/sweep/lambda", "remove one", false},
    {"/solvers/1/sweep", R"({"priors": ["noser"]})", "/solvers/1/sweep/priors",
     "there are prior, lambda", false},
    {"/solvers/1/sweep", R"({"seed": [1, 2]})", "/solvers/1/sweep/seed", "\"seeds\""},
    {"/solvers/1/sweep", R"({"label": ["a"]})", "/solvers/1/sweep/label", "cannot be swept"},
    {"/solvers/1/sweep", R"({"prior": []})", "/solvers/1/sweep/prior", "1 to 50"},
    {"/solvers/1/sweep", R"({"prior": "noser"})", "/solvers/1/sweep/prior", "1 to 50"},
    {"/solvers/1/sweep", R"({"prior": ["noser", "noser"]})", "/solvers/1/sweep/prior/1", "twice"},
    {"/solvers/1/sweep", R"({"prior": [["noser"]]})", "/solvers/1/sweep/prior/0",
     "list of numbers"},
    {"/solvers/1/sweep", R"({"prior": ["a/b"]})", "/solvers/1/sweep/prior/0", "letters", false},
    {"/charts", "{}", "/charts", "array"},
    {"/charts", R"([{"type": "pie", "name": "a"}])", "/charts/0/type", "\"heat-map\""},
    {"/charts", R"([{"type": "bars"}])", "/charts/0/name", "missing"},
    {"/charts", R"([{"type": "bars", "name": "a b"}])", "/charts/0/name", "letters"},
    {"/charts", R"([{"type": "bars", "name": "reconstructions"}])", "/charts/0/name", "taken",
     false},
    {"/charts", R"([{"type": "bars", "name": "a"}, {"type": "bars", "name": "a"}])",
     "/charts/1/name", "taken", false},
    {"/charts", R"([{"type": "bars", "name": "a", "solvers": []}])", "/charts/0/solvers", "labels"},
    {"/charts", R"([{"type": "bars", "name": "a", "solvers": ["tsvd", "tvsd"]}])",
     "/charts/0/solvers/1", "there are tsvd, one-step-gn, pdipm", false},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": ["ar"]}])", "/charts/0/metrics/0",
     "\"AR\"", false},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": [""]}])", "/charts/0/metrics/0",
     "\"AR\""},
    {"/charts", R"([{"type": "bars", "name": "a", "metrics": ["AR", "AR"]}])", "/charts/0/metrics",
     "twice"},
    {"/charts", R"([{"type": "bars", "name": "a", "dataset": "validation"}])", "/charts/0/dataset",
     "\"test\"", false},
    {"/charts", R"([{"type": "bars", "name": "a", "solver": "tsvd"}])", "/charts/0/solver",
     "did you mean \"solvers\""},
    {"/charts", R"([{"type": "heat-map", "name": "a", "solver": "tsvd"}])", "/charts/0/solver",
     "two parameters", false},
};

TEST(Experiment, BrokenFilesAreRefusedWithPlaceAndRemedy) {
  const TemporaryFolder folder("experiment");
  const auto file = folder / "broken.json";
  write_text(file, good().dump());
  ASSERT_EQ(refusal(file), "");
  ASSERT_EQ(schema_complaint(good()), "");
  for (const Broken& b : broken) {
    SCOPED_TRACE(std::string(b.place) + " = " + b.value);
    json value = good();
    const json::json_pointer place(b.place);
    if (std::string(b.value) == "remove") {
      value.at(place.parent_pointer()).erase(place.back());
    } else {
      value[place] = json::parse(b.value);
    }
    write_text(file, value.dump());
    const std::string message = refusal(file);
    EXPECT_EQ(message.rfind(file.string() + ": " + b.path + ":", 0), 0u) << message;
    EXPECT_NE(message.find(b.remedy), std::string::npos) << message;
    if (b.schema_can_tell) {
      EXPECT_NE(schema_complaint(value), "");
    }
  }
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

/// The good experiment with a toy network for its first solver.
json learned(const json& more) {
  json value = good();
  value["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
  value["solvers"][0] = {{"type", "toy-learned"}, {"label", "net"}};
  value["solvers"][0].update(more);
  return value;
}

TEST(Experiment, ASolverThatIsTrainedNeedsItsDatasets) {
  const TemporaryFolder folder("untrained");
  json value = learned({{"how", "needs data"}});
  value["datasets"].erase("train");
  write_text(folder / "e.json", value.dump());
  const std::string message = refusal(folder / "e.json");
  EXPECT_NE(message.find("/solvers/0/type: toy-learned is trained; add /datasets/train"),
            std::string::npos)
      << message;
}

TEST(Experiment, SeedsAndSweepsBecomeTrials) {
  const TemporaryFolder folder("trials");
  const json value = learned(
      {{"seeds", {3, 1}}, {"sweep", {{"level", {-1e-4, -0.125}}, {"how", {"crash", "diverge"}}}}});
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
  std::vector<std::string> stems;
  for (const SolverEntry& entry : e.solvers) stems.push_back(entry.stem());
  EXPECT_EQ(stems, (std::vector<std::string>{
                       "net how=crash level=-0.0001.seed3", "net how=crash level=-0.0001.seed1",
                       "net how=crash level=-0.125.seed3", "net how=crash level=-0.125.seed1",
                       "net how=diverge level=-0.0001.seed3", "net how=diverge level=-0.0001.seed1",
                       "net how=diverge level=-0.125.seed3", "net how=diverge level=-0.125.seed1",
                       "one-step-gn", "pdipm"}));
  EXPECT_EQ(e.rows().size(), 6u);
  EXPECT_EQ(e.rows()[1].size(), 2u);
  EXPECT_EQ(*e.solvers[2].spec, json::parse(R"({"type": "toy-learned", "label": "net",
      "how": "crash", "level": -0.125, "seed": 3})"));
  EXPECT_EQ(*e.solvers[2].sweep, json({{"how", "crash"}, {"level", -0.125}}));
}

TEST(Experiment, FamiliesAndSweptListsMakeTheirRows) {
  const TemporaryFolder folder("families");
  json value = good();
  value["solvers"] = json::parse(R"([
      {"type": "tsvd", "family": "linear", "sweep": {"rank": [10, 20]}},
      {"type": "one-step-gn", "family": "linear", "lambda": 1},
      {"type": "fcnn", "sweep": {"widths": [[16, 8], [32]]}}])");
  value["right_sizing"] = json::object();
  value["charts"] = json::parse(R"([
      {"type": "speed-accuracy", "name": "all"},
      {"type": "speed-accuracy", "name": "linear", "solvers": ["linear"], "metric": "PE"}])");
  value["charts"][0]["budgets_us"] = {50};
  EXPECT_EQ(schema_complaint(value), "");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e =
      read_experiment(folder / "e.json", registry, chart_types(), SolverCheck::none);
  ASSERT_EQ(e.solvers.size(), 5u);
  EXPECT_EQ(e.solvers[1].family, "linear");
  EXPECT_EQ(e.solvers[1].label, "tsvd rank=20");
  EXPECT_EQ(e.solvers[2].family, "linear");
  EXPECT_FALSE(e.solvers[2].spec->contains("family"));
  EXPECT_EQ(e.solvers[3].label, "fcnn widths=16-8");
  EXPECT_EQ(e.solvers[3].spec->at("widths"), json({16, 8}));
  const SpeedQuestion& all = dynamic_cast<const SpeedChart&>(*e.charts.at(0)).question();
  EXPECT_EQ(all.break_even_against, std::vector<std::string>{"one-step-gn"});
  EXPECT_EQ(all.budgets_us, std::vector<double>{50});
  const SpeedQuestion& linear = dynamic_cast<const SpeedChart&>(*e.charts.at(1)).question();
  EXPECT_EQ(linear.labels,
            (std::vector<std::string>{"tsvd rank=10", "tsvd rank=20", "one-step-gn"}));
  EXPECT_EQ(linear.metric, Metric::PE);
}

TEST(Cache, WhatIsAppliedOtherwiseSharesItsFit) {
  const TemporaryFolder folder("inference_key");
  json value = good();
  value["solvers"] = json::parse(R"([
      {"type": "tsvd", "rank": 10}, {"type": "tsvd", "label": "a", "rank": 10,
       "inference_precision": "float32", "inference_averaging": false},
      {"type": "tsvd", "label": "b", "rank": 11}])");
  write_text(folder / "e.json", value.dump());
  SolverRegistry registry;
  const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
  const Cache cache("c");
  EXPECT_EQ(cache.fitted_solver(fit_recipe(e, e.solvers[0])),
            cache.fitted_solver(fit_recipe(e, e.solvers[1])));
  EXPECT_NE(cache.fitted_solver(fit_recipe(e, e.solvers[0])),
            cache.fitted_solver(fit_recipe(e, e.solvers[2])));
  EXPECT_NE(accuracy_key(fit_recipe(e, e.solvers[0]), e.tests, {}),
            accuracy_key(fit_recipe(e, e.solvers[1]), e.tests, {}));
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

  const auto key = [](const Experiment& e, bool keep) {
    return accuracy_key(fit_recipe(e, e.solvers[0]), e.tests, {false, {}, e.contacts, keep});
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

TEST(Experiment, SeedsThatCannotBeAreRefused) {
  const TemporaryFolder folder("seeds_refused");
  const std::tuple<json, const char*, const char*> cases[] = {
      {{{"seeds", json::array()}}, "/solvers/0/seeds", "1 to 100"},
      {{{"seeds", 3}}, "/solvers/0/seeds", "list"},
      {{{"seeds", {1, 2, 1}}}, "/solvers/0/seeds/2", "twice"},
      {{{"seeds", {1, -1}}}, "/solvers/0/seeds/1", "from 0"},
      {{{"seeds", {1.5}}}, "/solvers/0/seeds/0", "whole"},
      {{{"seeds", {2147483648}}}, "/solvers/0/seeds/0", "2147483647"},
      {{{"seeds", {1, 2}}, {"seed", 1}}, "/solvers/0/seeds", "remove one"}};
  for (const auto& [more, path, remedy] : cases) {
    const json value = learned(more);
    write_text(folder / "e.json", value.dump());
    const std::string message = refusal(folder / "e.json");
    EXPECT_NE(message.find(std::string("e.json: ") + path + ": "), std::string::npos) << message;
    EXPECT_NE(message.find(remedy), std::string::npos) << message;
    EXPECT_NE(schema_complaint(value), "") << more;
  }
}

TEST(Experiment, LabelsOfSeedsAndSweepsMustNotMeetOthers) {
  const TemporaryFolder folder("labels");
  json value = learned({{"seeds", {1, 2}}});
  value["solvers"][1]["label"] = "net.seed2";  // the name of a record
  write_text(folder / "e.json", value.dump());
  EXPECT_NE(refusal(folder / "e.json").find("/solvers/1/label: \"net.seed2\" is taken"),
            std::string::npos);
  value = learned({{"label", std::string(55, 'x')}, {"sweep", {{"level", {0.5}}}}});
  write_text(folder / "e.json", value.dump());
  EXPECT_NE(refusal(folder / "e.json").find("with the values of a sweep"), std::string::npos);
}

TEST(Cache, ASeedOfManyHasTheKeyOfTheEntryWithThatSeedAlone) {
  const TemporaryFolder folder("seed_key");
  const Cache cache("c");
  const auto file = [&](const json& more, std::size_t entry) {
    write_text(folder / "e.json", learned(more).dump());
    SolverRegistry registry;
    const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
    return cache.fitted_solver(fit_recipe(e, e.solvers.at(entry)));
  };
  const auto alone = file({{"seed", 2}, {"level", 0.5}, {"label", "other"}}, 0);
  EXPECT_EQ(file({{"seeds", {1, 2}}, {"level", 0.5}}, 1), alone);
  EXPECT_EQ(file({{"seed", 2}, {"sweep", {{"level", {0.25, 0.5}}}}}, 1), alone);
  EXPECT_NE(file({{"seeds", {1, 2}}, {"level", 0.5}}, 0), alone);
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
                       {"initialisation", "random"},
                       {"sweep", {{"alpha", {0, 1e-3}}, {"beta", {0.1}}}}}),
            "");
  EXPECT_EQ(complaint({{"type", "fcnn"}, {"seed", 1}, {"widths", {2304, 576}}}), "");
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

TEST(Experiment, TextThatIsNotJsonIsRefused) {
  const TemporaryFolder folder("text");
  const auto file = folder / "text.json";
  const auto message_for = [&](const std::string& text) {
    write_text(file, text);
    return refusal(file);
  };
  EXPECT_NE(message_for("").find("text.json: not valid JSON"), std::string::npos);
  EXPECT_NE(message_for("{\"datasets\": ").find("line 1, column"), std::string::npos);
  EXPECT_NE(message_for("{\"solvers\": [], \"solvers\": []}").find("\"solvers\" stands twice"),
            std::string::npos);
  EXPECT_NE(message_for("[]").find("/: must be an object"), std::string::npos);
  EXPECT_NE(message_for("{\"time_limit_s\": 1e999}").find("text.json"), std::string::npos);
  EXPECT_NE(message_for(std::string(100000, '[')).find("text.json: is nested deeper than 64"),
            std::string::npos);
  EXPECT_NE(message_for(std::string("\0\xff\xfe", 3)).find("not valid JSON"), std::string::npos);
  EXPECT_NE(refusal(folder / "absent.json").find("cannot be opened"), std::string::npos);
  EXPECT_NE(refusal(folder.path()).find("is a directory"), std::string::npos);
}

TEST(Cache, KeyFollowsWhatDeterminesTheNumbersAndNothingElse) {
  const TemporaryFolder folder("key");
  const Cache cache("c");
  const auto keys = [&](const json& value) {
    write_text(folder / "e.json", value.dump());
    SolverRegistry registry;
    const Experiment e = read_experiment(folder / "e.json", registry, chart_types());
    return std::pair{cache.dataset(*e.validation),
                     cache.fitted_solver(fit_recipe(e, e.solvers[1]))};
  };
  const auto original = keys(good());
  json same = good();
  same["title"] = "other";
  same["solvers"][1]["label"] = "other";
  same["datasets"]["validation"]["rasterisation"] = "area";  // the default, written out
  EXPECT_EQ(keys(same), original);
  json reseeded = good();
  reseeded["datasets"]["validation"]["seed"] = 3;
  EXPECT_NE(keys(reseeded).first, original.first);
  EXPECT_NE(keys(reseeded).second, original.second);
  json fixed = good();
  fixed["solvers"][1]["lambda"] = 0.1;
  EXPECT_EQ(keys(fixed).first, original.first);
  EXPECT_NE(keys(fixed).second, original.second);
}

}  // namespace
}  // namespace ertbench
