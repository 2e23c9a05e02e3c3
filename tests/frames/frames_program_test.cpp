// Frames of one's own through the program: from file to image, calibration, and the lines
// of docs/own_frames.md in the programs that they are for.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/hdf5_file.h"
#include "core/text.h"
#include "frames/calibration.h"
#include "solvers/channel_mask.h"
#include "tests/bench/program.h"
#include "tests/bench/small_experiment.h"
#include "tests/frames/frames_testing.h"

namespace ertbench::testing {
namespace {

constexpr double pressed_x = 0.4;
constexpr double pressed_y = -0.3;
constexpr double two_pixels_mm = 17;  ///< two pixels

/// Twenty frames without contact, noise of 1e-5 V, then three of a disc at (pressed_x, pressed_y).
Frames measured_frames(const Sensor& sensor) {
  std::mt19937 random(8);
  std::normal_distribution<double> noise(0, 1e-5);
  const Eigen::RowVectorXd reference = BorderModel(sensor).reference_voltages().transpose();
  const RowMajorMatrix change = changes_by_discs(sensor, {{pressed_x, pressed_y}});
  Frames frames(23, sensor.channels());
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    frames.row(f) = reference;
    if (f >= 20) frames.row(f) += change.row(0);
    for (double& v : frames.row(f)) v += noise(random);
  }
  return frames;
}

void write_csv(const fs::path& file, const Frames& frames) {
  std::ofstream out(file);
  out.precision(12);
  for (Eigen::Index f = 0; f < frames.rows(); ++f) {
    for (Eigen::Index c = 0; c < frames.cols(); ++c) out << (c ? "," : "") << frames(f, c);
    out << '\n';
  }
}

const std::string solver = R"({"type": "one-step-gn", "prior": "noser", "lambda": 0.1})";

TEST(FramesProgram, ContactsExplainAMeasuredTankWithoutParameters) {
  const TemporaryFolder folder("tank");
  write_text(folder / "contacts.json", R"({"type": "contacts"})");
  const std::string project = ERTBENCH_SOURCE_DIR;
  const Outcome outcome =
      run_program(folder.path(), "reconstruct --solver contacts.json --input " +
                                     quoted(project + "/experiments/data/tank_adjacent.h5") +
                                     " --sensor " + quoted(project + "/sensors/tank.json") +
                                     " --background 20-57 --output images.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  const Hdf5File file = Hdf5File::open(folder / "images.h5");
  const RowMajorMatrix contacts = file.read_rows("/contacts", 0, 255, true);
  const RowMajorMatrix status = file.read_rows("/status", 0, 255);
  const auto is_flagged = [&](Eigen::Index f) { return status(f, 0) != 0; };
  // A glass cup is in the frames from 85 to 222, and nothing in those from 20 to 57.
  int flagged = 0;
  for (Eigen::Index f = 85; f <= 222; ++f) {
    flagged += is_flagged(f);
    EXPECT_FALSE(std::isnan(contacts(f, 0))) << f;
  }
  EXPECT_LE(flagged, 0.05 * 138);
  int empty = 0;
  for (Eigen::Index f = 20; f <= 57; ++f) empty += std::isnan(contacts(f, 0)) && !is_flagged(f);
  EXPECT_GE(empty, 0.5 * 38);
}

TEST(FramesProgram, ContactsAndTheLevelOfTheSheetAreWritten) {
  const TemporaryFolder folder("contacts");
  Frames frames = measured_frames({});
  constexpr double risen = 0.03;
  frames.bottomRows(1) /= 1 + risen;  // all of the sheet conducts better
  write_csv(folder / "frames.csv", frames);
  write_text(folder / "contacts.json",
             R"({"type": "contacts", "shape": "disc", "prior_weight": 1, "noise": 1e-5,
                 "nuisances": {"level": 0.1}})");
  const Outcome images = run_program(folder.path(),
                                     "reconstruct --solver contacts.json --input frames.csv "
                                     "--background 0-19 --output images.h5");
  ASSERT_EQ(images.exit_code, 0) << images.output;
  const Hdf5File file = Hdf5File::open(folder / "images.h5");
  EXPECT_EQ(file.shape("/contacts"), (std::vector<std::uint64_t>{23, 8, 6}));
  const RowMajorMatrix contacts = file.read_rows("/contacts", 0, 23, true);
  const RowMajorMatrix level = file.read_rows("/level", 0, 23);
  for (Eigen::Index f = 0; f < 20; ++f) EXPECT_TRUE(std::isnan(contacts(f, 0))) << f;
  for (const Eigen::Index f : {20, 22}) {
    EXPECT_NEAR(contacts(f, 0), 100 * pressed_x, 1) << f;
    EXPECT_NEAR(contacts(f, 1), 100 * pressed_y, 1) << f;
    EXPECT_GT(contacts(f, 2), 0) << f;
    EXPECT_LT(contacts(f, 3), 0.06) << f;
    EXPECT_LT(contacts(f, 4), 1) << f;
    EXPECT_TRUE(std::isnan(contacts(f, 6))) << "a second contact";
  }
  EXPECT_NEAR(level(20, 0), 0, 0.003);
  EXPECT_NEAR(level(22, 0), risen, 0.003);
}

// Those of a whole electrode, and one channel of which the reciprocal one is there.
TEST(FramesProgram, AStoredSolverImagesFramesWithoutSomeChannels) {
  const TemporaryFolder folder("without");
  Frames frames = measured_frames({});
  const auto image = [&] {
    write_csv(folder / "frames.csv", frames);
    return run_program(folder.path(),
                       "reconstruct --solver lean-net-8 --input frames.csv --background 0-19 "
                       "--output images.h5");
  };
  const auto image_21 = [&]() -> Eigen::VectorXd {
    return Hdf5File::open(folder / "images.h5")
        .read_rows("/conductivity_change", 21, 1)
        .row(0)
        .transpose();
  };
  ASSERT_EQ(image().exit_code, 0);
  const Eigen::VectorXd whole = image_21();
  const auto channels = electrodes_of_channels(Sensor{});
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto& [drive, measurement] = channels[c];
    const bool uses =
        drive.first == 9 || drive.second == 9 || measurement.first == 9 || measurement.second == 9;
    if (uses || c == 40) frames.col(static_cast<Eigen::Index>(c)).setConstant(std::nan(""));
  }
  const Outcome outcome = image();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_NE(outcome.output.find("(those of electrode 9, from 0)"), std::string::npos);
  EXPECT_NE(outcome.output.find("left out were estimated"), std::string::npos) << outcome.output;
  EXPECT_LT((image_21() - whole).norm(), 0.5 * whole.norm());
}

TEST(FramesProgram, AStoredSolverServesASheetThatConductsTwiceAsWell) {
  const TemporaryFolder folder("twice");
  const auto images_of = [&](const Frames& frames) {
    write_csv(folder / "empty.csv", frames.topRows(20));
    write_csv(folder / "frames.csv", frames);
    const Outcome calibrated = run_program(
        folder.path(), "calibrate empty.csv --sensor " +
                           quoted(ERTBENCH_SOURCE_DIR "/sensors/d2s.json") + " --out c.json");
    EXPECT_EQ(calibrated.exit_code, 0) << calibrated.output;
    const Outcome images = run_program(folder.path(),
                                       "reconstruct --solver contacts --calibration c.json "
                                       "--input frames.csv --output images.h5");
    EXPECT_EQ(images.exit_code, 0) << images.output;
    const Hdf5File file = Hdf5File::open(folder / "images.h5");
    return std::pair(file.read_rows("/conductivity_change", 21, 1),
                     file.read_rows("/contacts", 21, 1, true));
  };
  const auto [image, contacts] = images_of(measured_frames({}));
  const auto [twice, same] = images_of(0.5 * measured_frames({}));
  ASSERT_GT(image.norm(), 0);
  EXPECT_LT((twice - 2 * image).norm(), 0.01 * twice.norm());
  EXPECT_NEAR(same(0, 0), contacts(0, 0), 0.01);
  EXPECT_NEAR(same(0, 3), 2 * contacts(0, 3), 0.01 * std::abs(same(0, 3)));
}

// A robot may boot with a broken electrode: nothing of it changes then.
TEST(FramesProgram, AnElectrodeThatIsDeadInTheReferenceIsReplaced) {
  const TemporaryFolder folder("dead");
  const std::vector<ElectrodeSet> users = electrode_sets_of_channels(Sensor{});
  const auto without_5 = [&](Frames frames, Eigen::Index first) {
    for (Eigen::Index c = 0; c < frames.cols(); ++c) {
      const bool uses = users[static_cast<std::size_t>(c)] >> 5 & 1;
      if (uses) frames.col(c).tail(frames.rows() - first).setZero();
    }
    return frames;
  };
  const auto image_of = [&](const Frames& frames) -> Eigen::VectorXd {
    write_csv(folder / "frames.csv", frames);
    const Outcome outcome = run_program(folder.path(),
                                        "reconstruct --solver lean-net-8 --input frames.csv "
                                        "--background 0-19 --output images.h5");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    const Hdf5File file = Hdf5File::open(folder / "images.h5");
    EXPECT_EQ(file.read_rows("/reason", 21, 1)(0, 0), 1);  // a dead electrode
    return file.read_rows("/conductivity_change", 21, 1).row(0).transpose();
  };
  const Frames frames = measured_frames({});
  const Eigen::VectorXd later = image_of(without_5(frames, 20));
  EXPECT_LT((image_of(without_5(frames, 0)) - later).norm(), 0.02 * later.norm());

  {
    Hdf5File file = Hdf5File::create(folder / "frames.h5");
    file.write_matrix("/voltages", without_5(frames, 0));
  }
  const Outcome live =
      run_program(folder.path(),
                  "live --solver lean-net-8 --background 20 --lossless --input replay:frames.h5");
  EXPECT_EQ(live.exit_code, 0) << live.output;
  EXPECT_NE(live.output.find("\"dead_electrodes\":[5]"), std::string::npos) << live.output;

  // Its channels say nothing about the background.
  write_csv(folder / "empty.csv", without_5(frames, 0).topRows(20));
  const Outcome calibrated = run_program(folder.path(), "calibrate empty.csv --out c.json");
  EXPECT_EQ(calibrated.exit_code, 0) << calibrated.output;
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_EQ(c.dead_electrodes, std::vector<int>{5});
  EXPECT_NEAR(c.background, 0.06, 1e-4);
}

TEST(FramesProgram, ACalibrationWithoutSomeChannelsServesTheSameRecording) {
  const TemporaryFolder folder("missing");
  Frames frames = measured_frames({});
  frames.col(40).setConstant(std::nan(""));
  write_csv(folder / "frames.csv", frames);
  for (const std::string command :
       {"calibrate frames.csv --rows 0-19 --out c.json",
        "reconstruct --solver lean-net-8 --input frames.csv --calibration c.json --output o.h5"}) {
    const Outcome outcome = run_program(folder.path(), command);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  }
}

TEST(FramesProgram, AStoredSolverServesAnotherCurrent) {
  const TemporaryFolder folder("current");
  const Frames frames = measured_frames({});
  write_csv(folder / "frames.csv", frames);
  write_csv(folder / "weak.csv", 0.04 * frames);
  write_text(folder / "weak.json", R"({"drive_current": 0.001})");
  const auto image_of = [&](const std::string& input) {
    const Outcome outcome = run_program(
        folder.path(), "reconstruct --solver lean-net-8 --background 0-19 --output o.h5 " + input);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    return Hdf5File::open(folder / "o.h5").read_rows("/conductivity_change", 21, 1);
  };
  const RowMajorMatrix own = image_of("--input frames.csv");
  const RowMajorMatrix weak = image_of("--input weak.csv --sensor weak.json");
  EXPECT_LT((weak - own).norm(), 1e-4 * own.norm());
}

TEST(FramesProgram, CsvInMillivoltsBecomesPicturesAndTables) {
  const TemporaryFolder folder("csv");
  const Frames frames = measured_frames({});
  write_csv(folder / "frames.csv", 1e3 * frames);
  write_text(folder / "gn.json", solver);
  write_text(folder / "sensor.json", R"({"electrode_count": 16})");
  const std::string command =
      "reconstruct --solver gn.json --sensor sensor.json --input frames.csv --background 0-19 "
      "--output images.h5 --png images.png --csv images.csv";

  // Taken for volts, nothing is imaged.
  const Outcome wrong = run_program(folder.path(), command);
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.output.find("millivolts for volts; --unit mV"), std::string::npos)
      << wrong.output;
  EXPECT_NE(wrong.output.find("--fix reads the frames so"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "images.h5"));

  const Outcome right = run_program(folder.path(), command + " --unit mV");
  ASSERT_EQ(right.exit_code, 0) << right.output;
  EXPECT_NE(right.output.find("cannot be seen"), std::string::npos) << right.output;
  EXPECT_LT(
      (strongest(folder / "images.h5", 21) - 100 * Eigen::Vector2d(pressed_x, pressed_y)).norm(),
      two_pixels_mm);
  EXPECT_EQ(read_text(folder / "images.png").substr(1, 3), "PNG");
  const RowMajorMatrix declared =
      Hdf5File::open(folder / "images.h5").read_rows("/conductivity_change", 0, 23);
  {
    const Hdf5File images = Hdf5File::open(folder / "images.h5");
    const auto source = nlohmann::json::parse(images.read_text("/", "source"));
    EXPECT_EQ(source.at("input").at("format"), "CSV");
    EXPECT_EQ(source.at("input").at("checksum").get<std::string>().size(), 32u);
    EXPECT_EQ(source.at("unit"), "mV");
    EXPECT_EQ(source.at("mended"), false);
    EXPECT_EQ(nlohmann::json::parse(images.read_text("/", "sensor")).at("electrode_count"), 16);
    EXPECT_LT((images.read_vector("/reference_voltages").transpose() -
               frames.topRows(20).colwise().mean())
                  .norm(),
              1e-9);
  }
  const auto lines = csv_lines(read_text(folder / "images.csv"));
  ASSERT_EQ(lines.size(), 24u);
  ASSERT_EQ(lines[22].size(), 3u + 576);
  EXPECT_EQ(lines[0][3 + 25], "r1c1");
  EXPECT_EQ(std::stod(lines[22][3 + 100]), declared(21, 100));

  // Mended, the images are the same.
  const Outcome fixed = run_program(folder.path(), command + " --fix");
  ASSERT_EQ(fixed.exit_code, 0) << fixed.output;
  const Hdf5File images = Hdf5File::open(folder / "images.h5");
  EXPECT_LT((images.read_rows("/conductivity_change", 0, 23) - declared).norm(),
            1e-9 * declared.norm());
  EXPECT_EQ(nlohmann::json::parse(images.read_text("/", "source")).at("mended"), true);
  EXPECT_EQ(run_program(folder.path(), command + " --force").exit_code, 0);
}

TEST(FramesProgram, FramesOfAnotherUnitOrReferenceAreFlaggedWithTheReason) {
  const TemporaryFolder folder("flagged");
  Frames frames = measured_frames({});
  Frames references = frames.row(0).replicate(frames.rows(), 1);
  frames.row(21) *= 1000;
  frames.row(3) *= -1;
  references.row(7) *= 3;
  {
    Hdf5File file = Hdf5File::create(folder / "frames.h5");
    file.write_matrix("/voltages", frames);
    file.write_matrix("/reference_voltages", references);
    file.close();
  }
  write_text(folder / "gn.json", solver);
  const Outcome outcome = run_program(
      folder.path(), "reconstruct --solver gn.json --input frames.h5 --output images.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  for (const char* text : {"3 suspect", "frame 3: its voltages have the opposite sign",
                           "frame 7: its own reference is unlike", "(millivolts for volts?)"}) {
    EXPECT_NE(outcome.output.find(text), std::string::npos) << outcome.output;
  }
  const Hdf5File images = Hdf5File::open(folder / "images.h5");
  const Eigen::VectorXd reason = images.read_vector("/reason");
  EXPECT_EQ(reason[21], 32);
  EXPECT_EQ(reason[3], 16);
  EXPECT_EQ(static_cast<int>(reason[7]) & 128, 128);
  EXPECT_EQ((reason.array() != 0).count(), 3);
  EXPECT_EQ(images.read_vector("/status")[21], 3);
}

TEST(FramesProgram, WrongUseEndsWithCodeTwoAndARemedy) {
  const TemporaryFolder folder("wrong");
  write_csv(folder / "frames.csv", measured_frames({}));
  Frames shuffled = measured_frames({});
  std::mt19937 random(1);
  std::shuffle(shuffled.data(), shuffled.data() + shuffled.size(), random);
  write_csv(folder / "shuffled.csv", shuffled);
  write_text(folder / "gn.json", solver);
  write_text(folder / "old.mat", "MATLAB 5.0 MAT-file");
  write_text(folder / "words.csv", "1,2\nthree,4\n");
  write_text(folder / "letter.png", "Dear diary");
  write_text(folder / "bad.json", R"({"electrodes": 16})");
  const std::string to = " --output o.h5";
  const std::string start = "reconstruct --solver gn.json --input ";
  const std::pair<std::string, const char*> calls[] = {
      {start + "frames.csv" + to, "--background"},
      {start + "frames.csv --background 0-40" + to, "not among the 23"},
      {start + "frames.csv --background none.csv" + to, "none.csv: does not exist"},
      {start + "frames.csv --background 0-19 --unit kV" + to, "--unit: must be V, mV or uV"},
      {start + "frames.csv --background 0-19 --channels full" + to, "[N, 256]"},
      {start + "frames.csv --background 0-19 --sensor bad.json" + to, "bad.json: /electrodes"},
      {start + "frames.csv --background 0-19 --dataset x" + to, "leave --dataset out"},
      {start + "frames.csv --background 0-19 --calibration gn.json" + to,
       "gn.json: /: is no calibration"},
      {start + "frames.csv --background 0-19 --png letter.png" + to, "is no picture (PNG)"},
      {start + "frames.csv --background 0-19 --png a.jpg" + to, "must end in .png"},
      {start + "frames.csv --background 0-19 --csv letter.png" + to, "is no table of images"},
      {start + "shuffled.csv --background 0-19 --fix" + to, "name frames without contact alone"},
      {start + "old.mat" + to, "old.mat: is cut off"},
      {start + "words.csv" + to, "words.csv: line 2, column 1: must be a number"},
      {"calibrate frames.csv --rows 0-5 --out c.json", "choose by --rows"},
      {"calibrate frames.csv --rows five --out c.json", "--rows: must be FIRST-LAST"},
      {"calibrate shuffled.csv --out c.json", "nothing was calibrated"},
      {"calibrate frames.csv --out gn.json", "is no calibration"},
      {start + "frames.csv --background 0-19 --csv o.h5" + to, "o.h5: is the input o.h5"},
      {start + "frames.csv --background 0-19 --csv o.png --png o.png" + to, "o.png: is the input"},
      {start + "frames.csv --background ''" + to, "--background: must not be empty"},
      {"score frames.csv frames.csv", "frames.csv: cannot be opened as HDF5"},
  };
  for (const auto& [arguments, message] : calls) {
    const Outcome outcome = run_program(folder.path(), arguments);
    EXPECT_EQ(outcome.exit_code, 2) << arguments << ": " << outcome.output;
    EXPECT_NE(outcome.output.find(message), std::string::npos)
        << arguments << ": " << outcome.output;
    EXPECT_FALSE(fs::exists(folder / "o.h5"));
    EXPECT_FALSE(fs::exists(folder / "c.json"));
  }
  for (const std::string command : {"calibrate", "score"}) {
    const Outcome help = run_program(folder.path(), command + " --help");
    EXPECT_NE(help.output.find("Example:\n  ertbench "), std::string::npos);
  }
}

TEST(FramesProgram, ACalibrationChoosesParametersAndJudgesFrames) {
  const TemporaryFolder folder("calibrate");
  const Frames frames = measured_frames({});
  write_csv(folder / "frames.csv", 1.25 * frames);
  write_text(folder / "auto.json", R"({"type": "one-step-gn", "lambda": "auto"})");
  const Outcome calibrated =
      run_program(folder.path(), "calibrate frames.csv --rows 0-19 --out c.json");
  ASSERT_EQ(calibrated.exit_code, 0) << calibrated.output;
  const Calibration c = read_calibration(folder / "c.json");
  EXPECT_NEAR(c.background, 0.06 / 1.25, 1e-5);
  EXPECT_NEAR(c.noise.norm() / std::sqrt(208.0), 1.25e-5, 1e-6);
  EXPECT_NE(calibrated.output.find("noise of a channel  1.2e-05 V (rms)"), std::string::npos)
      << calibrated.output;

  const std::string command = "reconstruct --solver auto.json --input frames.csv --output o.h5";
  EXPECT_NE(run_program(folder.path(), command + " --background 0-19").output.find("auto.json: "),
            std::string::npos);
  const Outcome outcome = run_program(folder.path(), command + " --calibration c.json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("reads zero alone"), std::string::npos) << outcome.output;
  const Hdf5File images = Hdf5File::open(folder / "o.h5");
  EXPECT_GT(nlohmann::json::parse(images.read_text("/", "solver")).at("lambda").get<double>(), 0);
  EXPECT_LT((strongest(folder / "o.h5", 22) - 100 * Eigen::Vector2d(pressed_x, pressed_y)).norm(),
            two_pixels_mm);
  // Frames with five times the noise are found out; those that were calibrated on are not, but for
  // the false alarms of a check that was fitted on a few hundred scenes.
  EXPECT_LE((images.read_vector("/status").head(20).array() != 0).count(), 3);
  std::mt19937 random(9);
  std::normal_distribution<double> noise(0, 5 * 1.25e-5);
  Frames noisy = 1.25 * frames;
  for (double& v : noisy.reshaped()) v += noise(random);
  write_csv(folder / "frames.csv", noisy);
  const Outcome suspected = run_program(folder.path(), command + " --calibration c.json");
  EXPECT_NE(suspected.output.find("23 with more noise"), std::string::npos) << suspected.output;

  // In an experiment, in place of a validation set.
  nlohmann::json experiment = small_experiment();
  experiment["datasets"].erase("validation");
  experiment["solvers"] = {{{"type", "one-step-gn"}, {"lambda", "auto"}}};
  experiment["calibration"] = "c.json";
  write_text(folder / "own.json", experiment.dump());
  const Outcome ran = run_program(folder.path(), "run own.json --out own");
  ASSERT_EQ(ran.exit_code, 0) << ran.output;
  experiment["sensor"] = {{"electrode_count", 8}};
  write_text(folder / "own.json", experiment.dump());
  EXPECT_NE(run_program(folder.path(), "run own.json").output.find("c.json: /sensor: is another"),
            std::string::npos);
}

/// The first block of code in a language on the page.
std::string lines_of_page(const std::string& language) {
  const std::string page = read_text(ERTBENCH_SOURCE_DIR "/docs/own_frames.md");
  const std::size_t start = page.find("```" + language + "\n") + language.size() + 4;
  return page.substr(start, page.find("```", start) - start);
}

Eigen::Vector2d place_said(const std::string& output) {
  const std::size_t at = output.find("strongest at ");
  Eigen::Vector2d place(1e9, 1e9);
  if (at != std::string::npos)
    std::sscanf(output.c_str() + at, "strongest at %lf %lf", &place[0], &place[1]);
  return place;
}

bool runs(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1 </dev/null").c_str()) == 0;
}

Outcome run_lines(const fs::path& folder, const std::string& interpreter, const std::string& file) {
  return run_program(folder, quoted((folder / file).string()), interpreter);
}

/// A frame with a contact at a known place, as the page's lines see it.
void make_images(const TemporaryFolder& folder) {
  write_csv(folder / "frames.csv", measured_frames({}).bottomRows(1));
  write_csv(folder / "empty.csv", measured_frames({}).topRows(20));
  write_text(folder / "gn.json", solver);
  const Outcome outcome = run_program(folder.path(),
                                      "reconstruct --solver gn.json --input frames.csv "
                                      "--background empty.csv --output images.h5");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.output;
}

TEST(FramesProgram, ImagesOpenUprightInPython) {
  const char* const python = "/usr/bin/python3";
  if (!runs(std::string(python) + " -c 'import h5py'")) {
    GTEST_SKIP() << "needs the packages python3 and python3-h5py";
  }
  const TemporaryFolder folder("python");
  make_images(folder);
  write_text(folder / "lines.py", lines_of_page("python"));
  const Outcome said = run_lines(folder.path(), python, "lines.py");
  EXPECT_LT((place_said(said.output) - strongest(folder / "images.h5", 0)).norm(), 1e-3)
      << said.output;
  EXPECT_LT((place_said(said.output) - 100 * Eigen::Vector2d(pressed_x, pressed_y)).norm(),
            two_pixels_mm);
}

TEST(FramesProgram, ImagesOpenUprightInOctaveAndItsFramesAreRead) {
  const char* const octave = "/usr/bin/octave-cli";
  if (!runs(std::string(octave) + " --version")) GTEST_SKIP() << "needs the package octave";
  const TemporaryFolder folder("octave");
  make_images(folder);
  write_text(folder / "page_lines.m", lines_of_page("octave"));
  const Outcome said = run_lines(folder.path(), octave, "page_lines.m");
  EXPECT_LT((place_said(said.output) - strongest(folder / "images.h5", 0)).norm(), 1e-3)
      << said.output;

  // The way back: frames that Octave saves are those that it loaded.
  write_text(folder / "write_frames.m",
             "voltages = csvread('frames.csv'); reference_voltages = mean(csvread('empty.csv'))';\n"
             "save('-hdf5', 'frames.mat', 'voltages', 'reference_voltages');\n");
  // Octave's exit code tells of its plotting libraries, too.
  const Outcome saved = run_lines(folder.path(), octave, "write_frames.m");
  ASSERT_TRUE(fs::exists(folder / "frames.mat")) << saved.output;
  const RowMajorMatrix before =
      Hdf5File::open(folder / "images.h5").read_rows("/conductivity_change", 0, 1);
  const Outcome again = run_program(
      folder.path(), "reconstruct --solver gn.json --input frames.mat --output images.h5");
  ASSERT_EQ(again.exit_code, 0) << again.output;
  const Hdf5File images = Hdf5File::open(folder / "images.h5");
  EXPECT_LT((images.read_rows("/conductivity_change", 0, 1) - before).norm(), 1e-9 * before.norm());
  EXPECT_NE(images.read_text("/", "source").find("Octave HDF5"), std::string::npos);
}

}  // namespace
}  // namespace ertbench::testing
