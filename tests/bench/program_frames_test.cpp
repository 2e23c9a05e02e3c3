// Files of frames: generated, reconstructed, damaged.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "core/hdf5_file.h"
#include "forward/data/dataset_file.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

TEST(Program, GenerateWritesTheNamedDataset) {
  const TemporaryFolder folder("generate");
  write_text(folder / "small.json", small_experiment().dump());
  const Outcome outcome =
      run_program(folder.path(), "generate small.json --dataset test --out test.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(DatasetFile(folder / "test.h5").size(), 40u);
  EXPECT_EQ(run_program(folder.path(), "generate small.json").exit_code, 0);
  const Outcome unknown =
      run_program(folder.path(), "generate small.json --dataset tset --out x.h5");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.output.find("validation, test"), std::string::npos) << unknown.output;
  const Outcome nowhere =
      run_program(folder.path(), "generate small.json --dataset test --out absent/x.h5");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_NE(nowhere.output.find("folder"), std::string::npos) << nowhere.output;
}

TEST(Program, SaysWhereTheVoltagesMissTheirModelError) {
  const TemporaryFolder folder("missed_promise");
  nlohmann::json experiment = small_experiment();
  nlohmann::json& test = experiment["datasets"]["test"];
  test["count"] = 2;
  test["grid"] = "auto";
  test["model_error"] = 1e-6;  // of next to no noise: out of reach of contacts with corners
  test["snr_db"] = 200;
  test["scenes"]["shapes"] = {"rectangle"};
  experiment.erase("figure");
  write_text(folder / "small.json", experiment.dump());
  const std::string sentence =
      "2 of 2 scenes have voltages whose estimated error is above 1e-06 of "
      "the noise, at most ";
  for (const char* arguments :
       {"generate small.json --dataset test --out test.h5", "generate small.json",
        "generate small.json", "run small.json --out out"}) {
    const Outcome outcome = run_program(folder.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    const std::size_t where = outcome.output.find("test: " + sentence);
    EXPECT_NE(where, std::string::npos) << arguments << ": " << outcome.output;
    EXPECT_EQ(outcome.output.find(sentence, where + 10), std::string::npos) << "said twice";
  }
  EXPECT_NE(read_text(folder / "out/table.md").find(sentence), std::string::npos);
  EXPECT_NE(read_text(folder / "out/report.html").find(sentence), std::string::npos);
  const nlohmann::json missed = summary_of(folder / "out").at("missed_promises").at("test");
  EXPECT_EQ(missed.at("scenes"), 2);
  EXPECT_EQ(missed.at("sentence").get<std::string>().find(sentence), 0u);
}

/// EIDORS's frames and what EIDORS makes of them.
TEST(Program, ReconstructsFramesOfEidors) {
  const TemporaryFolder folder("reconstruct");
  const Hdf5File eidors = Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5");
  {
    Hdf5File frames = Hdf5File::create(folder / "frames.h5");
    frames.write_matrix("/voltages", eidors.read_rows("/scenes/voltages", 0, 6));
    frames.write_vector("/reference_voltages", eidors.read_vector("/reference_voltages"));
  }
  const std::pair<const char*, const char*> cases[] = {
      {"gn_tikhonov", R"({"type": "one-step-gn", "prior": "tikhonov", "lambda": 0.03})"},
      {"gn_noser", R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})"},
      {"gn_laplace", R"({"type": "one-step-gn", "prior": "laplace", "lambda": 0.01})"},
      {"tsvd", R"({"type": "tsvd", "threshold": 0.01})"}};
  for (const auto& [image, spec] : cases) {
    SCOPED_TRACE(image);
    write_text(folder / "solver.json", spec);
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver solver.json --input frames.h5 --output images.h5");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
    const Hdf5File images = Hdf5File::open(folder / "images.h5");
    EXPECT_EQ(images.shape("/conductivity_change"), (std::vector<std::uint64_t>{6, 24, 24}));
    EXPECT_EQ(images.read_vector("/status"), Eigen::VectorXd::Zero(6));
    const RowMajorMatrix mine = images.read_rows("/conductivity_change", 0, 6);
    const RowMajorMatrix theirs = eidors.read_rows(std::string("/images/") + image, 0, 6);
    EXPECT_LT((mine - theirs).norm(), 1e-8 * theirs.norm());
  }
}

TEST(Program, ReconstructSaysWhichFramesAreNotToBeTrusted) {
  const TemporaryFolder folder("suspect");
  const Hdf5File eidors = Hdf5File::open(ERTBENCH_TEST_DATA "/eidors_d2s.h5");
  RowMajorMatrix voltages = eidors.read_rows("/scenes/voltages", 0, 3);
  const std::vector<Channel> channels = channels_of(Sensor{});
  for (std::size_t c = 0; c < channels.size(); ++c) {
    // Electrode 5 belongs to the pairs 4 and 5.
    const bool dead = channels[c].drive / 2 * 2 == 4 || channels[c].measurement / 2 * 2 == 4;
    if (dead) voltages(1, static_cast<Eigen::Index>(c)) = 0;
  }
  {
    Hdf5File frames = Hdf5File::create(folder / "frames.h5");
    frames.write_matrix("/voltages", voltages);
    frames.write_vector("/reference_voltages", eidors.read_vector("/reference_voltages"));
  }
  const auto run = [&](const char* spec) {
    write_text(folder / "solver.json", spec);
    return run_program(folder.path(),
                       "reconstruct --solver solver.json --input frames.h5 --output images.h5");
  };
  const Outcome plain = run(R"({"type": "tsvd", "rank": 45})");
  EXPECT_NE(plain.output.find("1 suspect\n  1 with a dead electrode"), std::string::npos)
      << plain.output;
  {
    const Hdf5File images = Hdf5File::open(folder / "images.h5");
    EXPECT_EQ(images.read_vector("/status"), Eigen::Vector3d(0, 3, 0));
    EXPECT_EQ(images.read_vector("/reason"), Eigen::Vector3d(0, 1, 0));
  }
  const Outcome masked = run(R"({"type": "tsvd", "rank": 45, "channel_mask": "detect"})");
  EXPECT_NE(masked.output.find("0 suspect\n  1 with a dead electrode"), std::string::npos)
      << masked.output;
  const Hdf5File images = Hdf5File::open(folder / "images.h5");
  EXPECT_EQ(images.read_vector("/status"), Eigen::Vector3d::Zero());
  EXPECT_EQ(images.read_vector("/reason"), Eigen::Vector3d(0, 1, 0));
}

/// Random damage: whatever happens, it ends, with code 0 or 2, and leaves no half-written output.
TEST(Program, DamagedFramesNeverCrash) {
  const TemporaryFolder folder("damage");
  write_text(folder / "solver.json", R"({"type": "tsvd", "rank": 30})");
  write_text(folder / "small.json", small_experiment().dump());
  ASSERT_EQ(
      run_program(folder.path(), "generate small.json --dataset test --out good.h5").exit_code, 0);
  const std::string good = read_text(folder / "good.h5");
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int refused = 0;
  constexpr int attempts = 40;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    std::string bytes = good;
    if (attempt % 4 == 0) {
      bytes.resize(random() % bytes.size());
    } else {
      // The headers, spread over the file's first kilobytes and its end, are where it hurts.
      for (int i = 0; i < 1 + attempt % 16; ++i) {
        const std::size_t reach = std::min<std::size_t>(bytes.size(), 6000);
        const std::size_t at = random() % reach;
        bytes[attempt % 2 ? at : bytes.size() - 1 - at] = static_cast<char>(random());
      }
    }
    write_text(folder / "bad.h5", bytes);
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver solver.json --input bad.h5 --output out.h5");
    EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 2)
        << outcome.exit_code << ": " << outcome.output;
    if (outcome.exit_code == 2) {
      ++refused;
      EXPECT_NE(outcome.output.find("bad.h5"), std::string::npos) << outcome.output;
      EXPECT_FALSE(fs::exists(folder / "out.h5"));
    }
    fs::remove(folder / "out.h5");
  }
  EXPECT_GE(refused, attempts / 4);
}

}  // namespace
}  // namespace ertbench
