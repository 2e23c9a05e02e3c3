// What `ertbench live` says of frames, whatever they come from: of any sensor, by any solver, with
// contacts, forces and collisions.

#include <gtest/gtest.h>

#include <sstream>

#include "core/statistics.h"
#include "tests/bench/live_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

TEST(LiveSolver, TakesAnySensor) {
  json rectangle = small_experiment();
  rectangle["sensor"] = {{"shape", "rectangle"}, {"sides_mm", {300, 150}}, {"electrode_count", 32}};
  json disc = small_experiment();
  disc["sensor"] = {{"shape", "disc"}, {"diameter_mm", 100}};
  for (const json& experiment : {rectangle, disc}) {
    SCOPED_TRACE(experiment.at("sensor").dump());
    const LiveFolder folder(experiment);
    const Outcome images = run_program(
        folder.path(), "reconstruct --solver gn.json --input frames.h5 --output images.h5");
    ASSERT_EQ(images.exit_code, 0) << images.output;
    const Outcome live = run_program(folder.path(),
                                     "live --solver gn.json --input replay:frames.h5 --lossless "
                                     "--record record.h5");
    ASSERT_EQ(live.exit_code, 0) << live.output;
    const Hdf5File expected = Hdf5File::open(folder / "images.h5");
    const Hdf5File record = Hdf5File::open(folder / "record.h5");
    EXPECT_EQ(record.shape("/answer/conductivity_change"), expected.shape("/conductivity_change"));
    const RowMajorMatrix a = expected.read_rows("/conductivity_change", 0, 40);
    const RowMajorMatrix b = record.read_rows("/answer/conductivity_change", 0, 40);
    EXPECT_LT((a - b).norm(), 1e-10 * a.norm());
  }
}

// Files of instruments do not say what sensor they are of.
TEST(LiveSolver, ReplaysAMeasuredTank) {
  const TemporaryFolder folder("tank");
  write_text(folder / "contacts.json",
             R"({"type": "contacts", "shape": "disc", "most_contacts": 1, "noise": 3.4e-4,
                 "model_error": 0.08, "prior_weight": 1, "nuisances": {"level": 0.1}})");
  const std::string source = ERTBENCH_SOURCE_DIR;
  const auto live = [&](const std::string& sensor) {
    return run_program(folder.path(), "live --solver contacts.json --lossless --input replay:" +
                                          source + "/experiments/data/tank_adjacent.h5 --sensor " +
                                          source + "/sensors/" + sensor);
  };
  const Outcome told = live("tank.json");
  ASSERT_EQ(told.exit_code, 0) << told.output;
  int found = 0;
  std::istringstream lines(told.output);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("{")) continue;
    const json answer = json::parse(line);
    if (!answer.contains("frame") || answer.at("frame") < 85 || answer.at("frame") > 221) continue;
    found += answer.at("contacts").size() == 1;
  }
  EXPECT_EQ(found, 137);  // in every frame in which the cup is moved
  const Outcome other = live("rectangle_32.json");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.output.find("name theirs by --sensor"), std::string::npos) << other.output;
}

// Each frame's contacts begin where the last frame's were, and come to what they are found to be
// without it: discs that jump from frame to frame are the hardest case.
TEST(LiveSolver, ContactsThatFollowComeToTheSame) {
  const LiveFolder folder;
  write_text(folder / "contacts.json",
             R"({"type": "contacts", "shape": "disc", "noise": 7e-5, "prior_weight": 1})");
  const Outcome images = run_program(
      folder.path(), "reconstruct --solver contacts.json --input frames.h5 --output images.h5");
  ASSERT_EQ(images.exit_code, 0) << images.output;
  RunningProgram program(folder.path(), {"live", "--solver", "contacts.json", "--input",
                                         "replay:frames.h5", "--lossless"});
  program.close_input();
  const std::vector<json> answers = answers_of(program.lines());
  ASSERT_EQ(program.exit_code(), 0) << program.errors();
  const RowMajorMatrix found =
      Hdf5File::open(folder / "images.h5").read_rows("/contacts", 0, 40, true);
  ASSERT_EQ(answers.size(), 40U);
  int same = 0;
  for (std::size_t f = 0; f < answers.size(); ++f) {
    const json& contacts = answers[f].at("contacts");
    ASSERT_FALSE(contacts.empty()) << f;
    const auto row = static_cast<Eigen::Index>(f);
    same += std::abs(contacts[0].at("x_mm").get<double>() - found(row, 0)) < 0.2 &&
            std::abs(contacts[0].at("y_mm").get<double>() - found(row, 1)) < 0.2;
  }
  EXPECT_GE(same, 39);
}

TEST(LiveSolver, AnExperimentsSolverComesWithItsFit) {
  const LiveFolder folder;
  RunningProgram program(folder.path(),
                         {"live", "--experiment", "e.json", "--solver", "one-step-gn", "--input",
                          "replay:frames.h5", "--lossless", "--reference", "model"});
  const std::vector<json> lines = program.lines();
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  EXPECT_EQ(answers_of(lines).size(), 40u);
  // Each frame shows a disc with a radius of 20 mm; the strongest contact is to lie in it.
  const Hdf5File file = Hdf5File::open(folder / "frames.h5");
  const RowMajorMatrix truth = file.read_rows("/contacts", 0, 40, true);
  int found = 0;
  for (const json& answer : answers_of(lines)) {
    EXPECT_EQ(answer.at("status"), "ok");
    const auto frame = answer.at("frame").get<Eigen::Index>();
    const json& strongest = answer.at("contacts").at(0);
    const Eigen::Vector2d place(strongest.at("x_mm").get<double>(),
                                strongest.at("y_mm").get<double>());
    const Eigen::Vector2d centre = 100 * truth.block<1, 2>(frame, 1).transpose();
    found += (place - centre).norm() < 20;
  }
  EXPECT_GE(found, 38);
  const Outcome unknown =
      run_program(folder.path(), "live --experiment e.json --solver gn --input replay:frames.h5");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.output.find("it has one-step-gn, tsvd, pdipm"), std::string::npos)
      << unknown.output;
}

TEST(LiveSolver, WhatIsBelowTheFloorIsNoContact) {
  const LiveFolder folder;
  const auto peaks = [&](const std::string& floor) {
    RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input",
                                           "replay:frames.h5", "--lossless", "--floor", floor});
    std::vector<double> out;
    for (const json& contacts : contacts_of(program.lines())) {
      for (const json& one : contacts) out.push_back(one.at("peak").get<double>());
    }
    EXPECT_EQ(program.exit_code(), 0) << program.errors();
    return out;
  };
  const std::vector<double> all = peaks("0");
  const double floor = median(all);
  const auto above = std::count_if(all.begin(), all.end(), [&](double p) { return p > floor; });
  const std::vector<double> some = peaks(std::to_string(floor));
  EXPECT_NEAR(static_cast<double>(some.size()), static_cast<double>(above), 1);
  for (const double peak : some) EXPECT_GE(peak, floor - 1e-6);  // of the text's digits
}

// Thresholds for one false alarm a day from frames without contact, whose noise is that of the
// frames with a disc of 20 mm at 0.6 of the background: the quiet ones stay quiet, the others do
// not.
TEST(LiveSolver, CollisionsAreToldFromQuietFrames) {
  const LiveFolder folder;
  json quiet = small_experiment();
  quiet["datasets"]["test"]["count"] = 300;
  quiet["datasets"]["test"]["scenes"] = {{"contacts", 1}, {"blank_fraction", 1}};
  write_text(folder / "q.json", quiet.dump());
  const Outcome made = run_program(folder.path(), "generate q.json --dataset test --out quiet.h5");
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const auto alarms = [&](const std::string& frames) {
    RunningProgram program(folder.path(),
                           {"live", "--solver", "gn.json", "--input", "replay:" + frames, "--quiet",
                            "quiet.h5@100", "--false-alarms", "0.04", "--lossless"});
    int count = 0;
    for (const json& answer : answers_of(program.lines())) count += answer.at("alarm").get<bool>();
    EXPECT_EQ(program.exit_code(), 0) << program.errors();
    return count;
  };
  EXPECT_EQ(alarms("quiet.h5"), 0);
  EXPECT_EQ(alarms("frames.h5"), 40);
}

// Frames of a touch around the middle, whose forces the solver is told, and the same frames again:
// a touch is felt a little differently from place to place, and yet what is read back is far nearer
// than the mean of all forces, which is off by 9 N / sqrt(12) = 2.6 N.
TEST(LiveSolver, ForcesAreReadBack) {
  const LiveFolder folder;
  json touches = small_experiment();
  touches["sensor"] = {{"skin", {{"law", {{"type", "rising"}}}}}};
  touches["datasets"]["test"] = json::parse(R"({
    "seed": 5, "count": 60, "snr_db": 70, "snr_basis": "absolute",
    "scenes": {"touches": 1, "indenters": [{"type": "flat"}], "force_N": [1, 10],
               "margin_mm": 85}})");
  write_text(folder / "t.json", touches.dump());
  const Outcome made = run_program(folder.path(), "generate t.json --dataset test --out touch.h5");
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const Hdf5File file = Hdf5File::open(folder / "touch.h5");
  const RowMajorMatrix truth = file.read_rows("/forces", 0, file.shape("/forces")[0]);
  RunningProgram program(folder.path(), {"live", "--solver", "gn.json", "--input",
                                         "replay:touch.h5", "--forces", "touch.h5", "--lossless"});
  const std::vector<json> answers = answers_of(program.lines());
  EXPECT_EQ(program.exit_code(), 0) << program.errors();
  ASSERT_EQ(std::ssize(answers), truth.rows());
  double square = 0;
  for (std::size_t a = 0; a < answers.size(); ++a) {
    ASSERT_TRUE(answers[a].at("force_N").is_number()) << answers[a];
    const double error =
        answers[a].at("force_N").get<double>() - truth(static_cast<Eigen::Index>(a), 0);
    square += error * error / static_cast<double>(answers.size());
    double shares = 0;
    for (const json& contact : answers[a].at("contacts"))
      shares += contact.at("force_N").get<double>();
    EXPECT_NEAR(shares, answers[a].at("force_N").get<double>(), 1e-9);
  }
  EXPECT_LT(std::sqrt(square), 1);
}

}  // namespace
}  // namespace ertbench
