// `ertbench score`: the metrics of a run for images and truths from files.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "forward/sheet/sensor_json.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench::testing {
namespace {

TEST(ScoreProgram, ScoresAreThoseOfARun) {
  const TemporaryFolder folder("score");
  nlohmann::json experiment = small_experiment();
  experiment["datasets"].erase("validation");
  experiment["solvers"] = {{{"type", "tsvd"}, {"rank", 30}}};
  write_text(folder / "small.json", experiment.dump());
  write_text(folder / "tsvd.json", experiment["solvers"][0].dump());
  for (const char* command :
       {"run small.json --out out", "generate small.json --dataset test --out test.h5",
        "reconstruct --solver tsvd.json --input test.h5 --output images.h5",
        "score images.h5 test.h5 --json scores.json"}) {
    const Outcome outcome = run_program(folder.path(), command);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  }
  const auto scores = nlohmann::json::parse(read_text(folder / "scores.json"));
  const nlohmann::json row = row_of(summary_of(folder / "out"), "tsvd");
  // Without a validation set the rule that reads contacts is the default one in both.
  for (const auto& [name, expected] : row.at("metrics").items()) {
    const nlohmann::json& found = scores.at("metrics").at(name);
    for (const char* what : {"mean", "median"}) {
      EXPECT_NEAR(found.at(what).get<double>(), expected.at(what).get<double>(),
                  1e-9 * std::abs(expected.at(what).get<double>()) + 1e-12)
          << name << " " << what;
    }
    EXPECT_EQ(found.at("undefined"), expected.at("undefined")) << name;
  }

  // The truth itself, as images from elsewhere without scenes, is perfect but for what is counted.
  {
    const Hdf5File truth = Hdf5File::open(folder / "test.h5");
    RowMajorMatrix images = truth.read_rows("/conductivity", 0, 40);
    Hdf5File bare = Hdf5File::create(folder / "bare.h5");
    bare.create_dataset("/conductivity", {40, 24, 24});
    bare.write_rows("/conductivity", 0, images);
    Hdf5File other = Hdf5File::create(folder / "other.h5");
    other.create_dataset("/conductivity", {40, 24, 24});
    other.write_rows("/conductivity", 0, 1.5 * images);
    images.row(7).setConstant(NAN);
    Hdf5File perfect = Hdf5File::create(folder / "perfect.h5");
    perfect.create_dataset("/conductivity", {40, 24, 24});
    perfect.write_rows("/conductivity", 0, images);
    Hdf5File fewer = Hdf5File::create(folder / "fewer.h5");
    fewer.create_dataset("/conductivity_change", {39, 24, 24});
    fewer.write_rows("/conductivity_change", 0, images.topRows(39));
  }
  const Outcome perfect = run_program(folder.path(), "score perfect.h5 bare.h5 --json scores.json");
  ASSERT_EQ(perfect.exit_code, 0) << perfect.output;
  const auto best = nlohmann::json::parse(read_text(folder / "scores.json"));
  EXPECT_EQ(best.at("undefined_frames"), 1);
  for (const auto& [name, ideal] : {std::pair("AR", 1.0),
                                    {"relative_error", 0.0},
                                    {"RIE", 0.0},
                                    {"detected", 1.0},
                                    {"false_positives", 0.0},
                                    {"precision", 1.0}}) {
    EXPECT_NEAR(best.at("metrics").at(name).at("mean").get<double>(), ideal, 1e-9) << name;
    EXPECT_EQ(best.at("metrics").at(name).at("undefined"), 1) << name;
  }
  const Outcome fewer = run_program(folder.path(), "score fewer.h5 bare.h5");
  EXPECT_EQ(fewer.exit_code, 2);
  EXPECT_NE(fewer.output.find("holds 39 images"), std::string::npos) << fewer.output;
  const Outcome other = run_program(folder.path(), "score other.h5 other.h5");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.output.find("name yours by --sensor"), std::string::npos) << other.output;

  // Truths and images that contradict the sensor or each other.
  const auto refused = [&](const char* name, const RowMajorMatrix& truth, double status,
                           const Sensor& sensor) {
    Hdf5File file = Hdf5File::create(folder / name);
    for (const char* dataset : {"/conductivity", "/conductivity_change"}) {
      file.create_dataset(dataset, {40, 24, 24});
      file.write_rows(dataset, 0, truth);
    }
    file.write_vector("/status", Eigen::VectorXd::Constant(40, status));
    file.write_text("/", "sensor", to_json(sensor).dump());
    file.close();
    const std::string images = status == 0 && sensor == Sensor{} ? "perfect.h5" : name;
    const std::string true_images = images == name ? "bare.h5 --sensor d2s.json" : name;
    return run_program(folder.path(), "score " + images + " " + true_images).output;
  };
  write_text(folder / "d2s.json", to_json(Sensor{}).dump());
  const RowMajorMatrix truth = Hdf5File::open(folder / "bare.h5").read_rows("/conductivity", 0, 40);
  const auto uniform = [&](double value) -> RowMajorMatrix {
    return RowMajorMatrix::Constant(40, 576, value);
  };
  Sensor wide;
  wide.background = 0.12;
  for (const auto& [output, message] :
       {std::pair(refused("a.h5", -truth, 0, {}), "it cannot be negative"),
        {refused("b.h5", 100 * truth, 0, {}), "not 0.06 S/m, the background"},
        {refused("c.h5", uniform(0), 0, {}), "has the median 0 S/m"},
        {refused("d.h5", uniform(0.07), 0, {}), "is uniform at 0.07 S/m"},
        {refused("e.h5", truth, 9, {}), "has the status 9"},
        {refused("f.h5", truth, 2.5, {}), "has the status 2.5"},
        {refused("g.h5", truth, 0, wide), "\"background\" 0.12, that of d2s.json 0.06"}}) {
    EXPECT_NE(output.find(message), std::string::npos) << output;
  }
  EXPECT_NE(best.dump().find("PE (sheet 2 × 2)"), std::string::npos);
}

}  // namespace
}  // namespace ertbench::testing
