// What a user does with a recording of his own tank: the experiment stays, sensor and file change.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

constexpr std::uint64_t empty_frames = 40;
constexpr std::uint64_t cup_frames = 30;
constexpr std::uint64_t reference_frames = 10;

/// Frames of a tank that is driven and measured over two electrodes, first without and then with
/// a cup of 17 mm, in the form that instruments leave: voltages and the mean of the first.
void record(const fs::path& folder) {
  const fs::path tank = fs::path(ERTBENCH_SOURCE_DIR) / "sensors/tank.json";
  json sensor = json::parse(read_text(tank));
  sensor["drive"] = {{"skip", 2}};
  sensor.erase("measurement");
  write_text(folder / "skip2.json", sensor.dump());
  const json noise = {{"grid", "auto"}, {"snr_db", 65}, {"snr_basis", "absolute"}};
  json empty = {{"count", empty_frames}, {"seed", 9}, {"scenes", {{"contacts", 0}}}};
  json cup = {{"count", cup_frames},
              {"seed", 10},
              {"scenes",
               {{"contacts", 1},
                {"shapes", {"disc"}},
                {"radius_mm", 17},
                {"conductivity_ratio", 0.02},
                {"placement", "inside"}}}};
  empty.update(noise);
  cup.update(noise);
  write_text(folder / "made.json", json{{"sensor", "skip2.json"},
                                        {"datasets", {{"empty", empty}, {"cup", cup}}},
                                        {"solvers", {{{"type", "one-step-gn"}, {"lambda", 0.1}}}}}
                                       .dump());
  const auto voltages_of = [&](const std::string& set, std::uint64_t count) {
    const Outcome made =
        run_program(folder, "generate made.json --dataset " + set + " --out " + set + ".h5");
    if (made.exit_code != 0) throw std::runtime_error(made.output);
    return Hdf5File::open(folder / (set + ".h5")).read_rows("/voltages", 0, count);
  };
  const RowMajorMatrix without = voltages_of("empty", empty_frames);
  const RowMajorMatrix with = voltages_of("cup", cup_frames);
  RowMajorMatrix all(without.rows() + with.rows(), without.cols());
  all << without, with;
  Hdf5File out = Hdf5File::create(folder / "recording.h5");
  const auto channels = static_cast<std::uint64_t>(all.cols());
  out.create_dataset("/voltages", {empty_frames + cup_frames, channels});
  out.write_rows("/voltages", 0, all);
  out.create_dataset("/reference_voltages", {channels});
  const RowMajorMatrix reference = without.topRows(reference_frames).colwise().mean();
  out.write_rows("/reference_voltages", 0, reference.transpose());
}

TEST(OtherRecording, OfATankNeedsItsSensorAndItsFileAlone) {
  const TemporaryFolder folder("recording");
  record(folder.path());
  const fs::path tank = fs::path(ERTBENCH_SOURCE_DIR) / "experiments/tank.json";
  const std::string recording = quoted((folder / "recording.h5").string());
  const Outcome run = run_program(
      folder.path(), "run " + quoted(tank.string()) +
                         " --out out --set sensor=skip2.json --set datasets.cup.file=" + recording +
                         " --set datasets.empty.file=" + recording +
                         " --set datasets.cup.rows=[40,70] --set datasets.empty.rows=[10,40]"
                         " --set datasets.train.count=300"
                         " --set datasets.validation.count=100 --set timing.enabled=false"
                         " --only contacts,lmmse");
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const json summary = summary_of(folder / "out");
  const json& found = summary.at("studies").at("consistency").at("sets").at("cup");
  const json& contacts = found.at("solvers").at("contacts");
  EXPECT_EQ(contacts.at("seen"), cup_frames);
  EXPECT_EQ(contacts.at("empty_frames"), empty_frames - reference_frames);
  EXPECT_EQ(contacts.at("false_contacts"), 0);
  // Ratio and radius are nearly one number to the voltages, so that the radius follows the prior.
  EXPECT_NEAR(contacts.at("radius_mm").at("value").get<double>(), 17, 3);
  EXPECT_LT(contacts.at("radius_spread").at("value").get<double>(), 0.05);
}

/// Every fourth press of the project's skin, as a file of its own.
void write_other_presses(const fs::path& file) {
  const Hdf5File skin =
      Hdf5File::open(fs::path(ERTBENCH_SOURCE_DIR) / "experiments/data/skin_presses.h5");
  Hdf5File out = Hdf5File::create(file);
  for (const char* name : {"/voltages", "/reference_voltages", "/positions_mm", "/depth_mm"}) {
    std::vector<std::uint64_t> shape = skin.shape(name);
    const RowMajorMatrix all = skin.read_rows(name, 0, shape[0]);
    const Eigen::Index count = all.rows() / 4;
    shape[0] = static_cast<std::uint64_t>(count);
    out.create_dataset(name, shape);
    out.write_rows(name, 0, all(Eigen::seqN(0, count, 4), Eigen::all));
  }
}

// The two ways that docs/skin.md names.
TEST(OtherRecording, OfASkinIsTriedOnOrLearnedFrom) {
  const TemporaryFolder folder("presses");
  write_other_presses(folder / "other.h5");
  const std::string other = (folder / "other.h5").string();
  const std::string run =
      "run " + quoted((fs::path(ERTBENCH_SOURCE_DIR) / "experiments/skin.json").string()) +
      " --only kernel-ridge --set timing.enabled=false --set datasets.test.file=" + quoted(other);
  const auto error_mm = [&](const fs::path& results) {
    return row_of(summary_of(results), "kernel-ridge")
        .at("metrics")
        .at("location_error_mm")
        .at("mean")
        .get<double>();
  };
  const Outcome tried = run_program(
      folder.path(), run + " --out tried --set folds=null --set datasets.test.rows=null");
  ASSERT_EQ(tried.exit_code, 0) << tried.output;
  // Most of these presses are learned from too: better than the 2.9 mm of presses that are not.
  EXPECT_LT(error_mm(folder / "tried"), 2.5);
  const std::string learn = run + " --set datasets.train.file=" + quoted(other) +
                            " --set datasets.train.rows=[0,64]" +
                            " --set datasets.validation.file=" + quoted(other) +
                            " --set datasets.validation.rows=[64,80] --set folds.rows=[0,100]" +
                            " --set folds.presses=[40,80]";
  const Outcome learned =
      run_program(folder.path(), learn + " --out learned --set datasets.test.rows=[80,100]");
  ASSERT_EQ(learned.exit_code, 0) << learned.output;
  EXPECT_LT(error_mm(folder / "learned"), 15);  // guessing the middle: 47 mm
  const json presses = summary_of(folder / "learned").at("studies").at("presses");
  EXPECT_EQ(presses.at("presses"), (json{40, 80}));
  const Outcome seen =
      run_program(folder.path(), learn + " --out seen --set datasets.test.rows=[70,100]");
  EXPECT_EQ(seen.exit_code, 2);
  EXPECT_NE(seen.output.find("/datasets/test: has 10 frames of other.h5 that \"validation\""),
            std::string::npos)
      << seen.output;
  const Outcome in_mv = run_program(
      folder.path(), learn + " --out in_mv --set datasets.test.rows=[80,100] --set folds=null" +
                         " --set datasets.test.scale=1000");
  EXPECT_NE(in_mv.output.find("warning: test: reference voltages are 985 times those of"),
            std::string::npos)
      << in_mv.output;
}

}  // namespace
}  // namespace ertbench
