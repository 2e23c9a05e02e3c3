// The protocol's side of the benchmark, against programs that keep to it and programs that do not.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <fstream>

#include "core/errors.h"
#include "solvers/external/program.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;
namespace fs = std::filesystem;

json program_of(const std::string& mode, const json& more = json::object()) {
  json spec = {{"type", "command"},
               {"command", {"python3", ERTBENCH_TEST_DATA "/programs/child.py", mode}}};
  if (more.is_object()) spec.update(more);
  return spec;
}

/// What tests/data/programs/child.py makes of frames.
Images expected_images(const Frames& changes, double gain) {
  Images images(changes.rows(), Sensor{}.pixels());
  for (Eigen::Index p = 0; p < images.cols(); ++p) {
    images.col(p) = gain * changes.col(p % changes.cols());
  }
  return images;
}

/// How a program fails in `fit` or with its first frame.
std::pair<std::string, std::string> failure_of_program(const std::string& mode,
                                                       const json& more = json::object()) {
  try {
    const std::unique_ptr<Solver> solver = fitted(program_of(mode, more));
    for (int i = 0; i < 2; ++i) reconstruct(*solver, Frames::Zero(1, Sensor{}.channels()));
  } catch (const FailedTrial& failed) {
    return {failed.status(), failed.what()};
  }
  return {"ok", ""};
}

TEST(CommandSolver, HasTheImagesOfItsProgram) {
  const auto solver = fitted(program_of("plain", {{"parameters", {{"gain", 2.5}}}}));
  EXPECT_EQ(solver->parameters().at("parameters"), (json{{"gain", 2.5}}));
  for (const int frames : {1, 2, 128, 129, 300}) {
    const Frames changes = random_matrix(frames, Sensor{}.channels(), 7);
    EXPECT_EQ(reconstruct(*solver, changes).images, expected_images(changes, 2.5)) << frames;
  }
}

// What it answered may be that of a program that was going wrong.
TEST(CommandSolver, AnEndBehindTheLastImageCounts) {
  const auto end_of = [](const std::string& mode) -> std::pair<std::string, std::string> {
    try {
      reconstruct(*fitted(program_of(mode)), Frames::Zero(1, Sensor{}.channels()));
      require_programs_ended_well();
    } catch (const FailedTrial& failed) {
      return {failed.status(), failed.what()};
    }
    return {"ok", ""};
  };
  EXPECT_EQ(end_of("plain").first, "ok");
  EXPECT_EQ(end_of("die-at-end").first, "crashed");
  const auto [status, said] = end_of("fail-at-end");
  EXPECT_EQ(status, "failed");
  EXPECT_NE(said.find("ended badly (exit code 3) after its last answer"), std::string::npos)
      << said;
  EXPECT_NE(end_of("hang-at-end").second.find("did not end within"), std::string::npos);
  EXPECT_EQ(end_of("plain").first, "ok");
}

TEST(CommandSolver, TellsTheProgramWhatTheProtocolSays) {
  const TemporaryFolder folder("told");
  const ValidationFile set(100);
  FitInput input;
  input.validation = set.input().validation;
  input.work_folder = folder.path();
  input.threads = 2;
  const auto solver = make_solver(program_of("fit", {{"parameters", {{"any", {1, "a"}}}}}));
  solver->fit(input);
  std::ifstream in(folder / "fits.txt");
  const json told = json::parse(in);
  json expected = {{"protocol", 1},  // and no "seed", which the entry has not
                   {"sensor", to_json(Sensor{})},
                   {"channels", 208},
                   {"image", {24, 24}},
                   {"background", 0.06},
                   {"train", nullptr},
                   {"validation", fs::absolute(input.validation->path()).string()},
                   {"parameters", {{"any", {1, "a"}}}},
                   {"work_folder", folder.path().string()},
                   {"threads", 2}};
  const Eigen::VectorXd& reference = input.validation->reference_voltages();
  expected["reference_voltages"] = std::vector<double>(reference.begin(), reference.end());
  EXPECT_EQ(told, expected);
}

TEST(CommandSolver, TellsOfAnySensor) {
  for (const char* text :
       {R"({"shape": "rectangle", "sides_mm": [300, 150], "electrode_count": 32})",
        R"({"shape": "disc", "diameter_mm": 100, "drive": "opposite"})"}) {
    SCOPED_TRACE(text);
    const json spec = json::parse(text);
    const TemporaryFolder folder("told");
    FitInput input;
    input.sensor = sensor_from_json(JsonObject(spec, "", ""));
    input.work_folder = folder.path();
    const auto solver = make_solver(program_of("fit"));
    solver->fit(input);
    std::ifstream in(folder / "fits.txt");
    const json told = json::parse(in);
    const PixelGrid image = input.sensor.image();
    EXPECT_EQ(told.at("image"), (json{image.rows(), image.columns()}));
    EXPECT_EQ(told.at("channels"), input.sensor.channels());
    EXPECT_EQ(told.at("reference_voltages").size(),
              static_cast<std::size_t>(input.sensor.channels()));
    const Frames changes = random_matrix(2, input.sensor.channels(), 8);
    Images images(2, input.sensor.pixels());
    std::vector<FrameReport> reports(2);
    solver->reconstruct(changes, images, reports);
    for (Eigen::Index p = 0; p < images.cols(); ++p) {
      const bool on_sheet = image.on_sheet(static_cast<int>(p));
      EXPECT_EQ(images(1, p), on_sheet ? changes(1, p % changes.cols()) : 0) << p;
    }
  }
}

TEST(CommandSolver, IsStartedAgainWhereItsProgramFindsItsFiles) {
  const TemporaryFolder folder("again");
  FitInput input;
  input.work_folder = folder / "x.work";
  fs::create_directories(input.work_folder);
  const auto solver = make_solver(program_of("fit"));
  solver->fit(input);
  EXPECT_EQ(solver->parameters().at("parameters").at("fits"), 1);
  solver->save(folder / "x.fitted");
  // The file and the folder may be moved together.
  const TemporaryFolder moved("moved");
  fs::copy(folder.path(), moved.path(), fs::copy_options::recursive);
  fs::remove_all(folder / "x.work");
  const auto loaded = make_solver(program_of("fit"));
  loaded->load(moved / "x.fitted", Sensor{});
  EXPECT_EQ(loaded->parameters().at("parameters").at("fits"), 0);
  EXPECT_FALSE(fs::exists(folder / "x.work"));
}

/// Examples that a program of protocol 2 has got.
struct Examples {
  Frames changes;
  Images images;
};

/// What the mode "scenes" has got, 5, 5 and 3 of them.
Examples examples_of(const DatasetSpec& spec, const json& more = json::object()) {
  const TemporaryFolder folder("scenes");
  generate_dataset(spec, folder / "train.h5");
  const DatasetFile train(folder / "train.h5");
  FitInput input;
  input.training = &train;
  input.work_folder = folder.path();
  json row = program_of("scenes", {{"protocol", 2}});
  row.update(more);
  make_solver(row)->fit(input);
  std::ifstream in(folder / "scenes.bin", std::ios::binary);
  Examples out{Frames(13, spec.sensor.channels()), Images(13, spec.sensor.pixels())};
  Eigen::Index first = 0;
  for (const Eigen::Index n : {5, 5, 3}) {
    for (RowMajorMatrix* rows : {&out.changes, &out.images}) {
      RowMajorMatrix some(n, rows->cols());
      in.read(reinterpret_cast<char*>(some.data()), some.size() * 8);
      rows->middleRows(first, n) = some;
    }
    first += n;
  }
  EXPECT_TRUE(in.good());
  EXPECT_EQ(in.peek(), std::ifstream::traits_type::eof());
  return out;
}

/// Pixels of each image in the order of their values, which no symmetry changes.
Images sorted_pixels(Images images) {
  for (auto row : images.rowwise()) std::sort(row.begin(), row.end());
  return images;
}

TEST(CommandSolver, SendsFreshScenesToAProgramThatAsks) {
  DatasetSpec spec = random_contacts(20);
  spec.noise.snr_db.reset();
  const Examples clean = examples_of(spec);
  // Each frame is that of its image, in whatever symmetry both are.
  const ForwardModel model(Sensor{}, 24);
  const Images conductivity = clean.images.array() + Sensor{}.background;
  const Frames frames =
      model.solve(conductivity).rowwise() - model.reference_voltages().transpose();
  EXPECT_LT(relative_difference(clean.changes, frames), 1e-9);
  // They are the scenes behind the set's last, the same for every seed but for their turns.
  DatasetSpec longer = spec;
  longer.count = 33;
  const Images behind =
      generate_block(longer, SceneModel(Sensor{}, GridSheet{24}), 20, 13).conductivity;
  const Images truths = behind.array() - Sensor{}.background;
  EXPECT_LT(relative_difference(sorted_pixels(clean.images), sorted_pixels(truths)), 1e-12);
  const Examples other = examples_of(spec, {{"seed", 7}});
  EXPECT_LT(relative_difference(sorted_pixels(other.images), sorted_pixels(truths)), 1e-12);
  EXPECT_GT(relative_difference(other.images, clean.images), 0.1);
  // Noise as the set has it, 50 dB.
  const Examples noisy = examples_of(random_contacts(20));
  EXPECT_EQ(noisy.images, clean.images);
  for (int i = 0; i < 13; ++i) {
    const double signal = (frames.row(i) + model.reference_voltages().transpose()).norm();
    EXPECT_NEAR(20 * std::log10(signal / (noisy.changes - frames).row(i).norm()), 50, 1e-6) << i;
  }
}

TEST(CommandSolver, PassesOnTheStatusOfFrames) {
  const auto solver = fitted(program_of("status"));
  const Reconstruction out = reconstruct(*solver, random_changes(4));
  EXPECT_EQ(out.reports[0].status, FrameStatus::ok);
  EXPECT_EQ(out.reports[1].status, FrameStatus::not_converged);
  EXPECT_EQ(out.reports[3].status, FrameStatus::not_converged);
}

TEST(CommandSolver, ReportsAFrameWithNaNAsUndefined) {
  const auto solver = fitted(program_of("nan"));
  const Reconstruction out = reconstruct(*solver, random_changes(2));
  EXPECT_EQ(out.reports[0].status, FrameStatus::undefined);
  EXPECT_EQ(out.reports[1].status, FrameStatus::ok);
}

TEST(CommandSolver, SaysWhatHappenedToItsProgram) {
  const auto expect = [](const std::string& mode, const json& more, const char* status,
                         const char* part) {
    const auto [found, message] = failure_of_program(mode, more);
    EXPECT_EQ(found, status) << mode << ": " << message;
    EXPECT_NE(message.find(part), std::string::npos) << mode << ": " << message;
  };
  expect("plain", {}, "ok", "");
  expect("crash-early", {}, "crashed", "Segmentation fault");
  expect("crash", {}, "crashed", "Segmentation fault");
  expect("raise", {}, "failed", "ValueError: no sheet without electrodes");
  expect("quit", {}, "failed", "exit code 3) before it had answered; it said: out of ideas");
  expect("close", {}, "failed", "closed its standard input or output");
  expect("slow", {{"ready_limit_s", 0.5}}, "timed out", "was not ready after");
  expect("hang", {{"frame_limit_s", 0.5}}, "timed out", "had not answered after");
  expect("refuse", {}, "failed", "says: needs a training set");
  expect("chat", {}, "failed", "got «I am ready!»");
  expect("endless", {}, "failed", "no end after");
  expect("print", {}, "failed", "more to its standard output than it was asked for");
  expect("short", {{"frame_limit_s", 0.5}}, "timed out", "had not answered");
  expect("long", {}, "failed", "than it was asked for");
  expect("odd-status", {}, "failed", "the status 9");
  expect("scenes", {}, "failed", "scenes need \"protocol\": 2 in its row");
  expect("scenes", {{"protocol", 2}}, "failed", "there is no /datasets/train");
  expect("many-scenes", {{"protocol", 2}}, "failed", "must be 1 to 65536 at a time, got 1048576");
  expect("memory", {{"memory_limit_mb", 200}}, "out of memory", "more than 200 MB");
  json absent = program_of("plain");
  absent["command"][0] = "no-such-program";
  try {
    fitted(absent);
    ADD_FAILURE() << "an absent program has started";
  } catch (const FailedTrial& failed) {
    EXPECT_NE(std::string(failed.what()).find("No such file"), std::string::npos) << failed.what();
  }
}

TEST(CommandSolver, EndsItsProgramWithAllThatItStarted) {
  const TemporaryFolder folder("left");
  json spec = program_of("leave");
  spec["command"].push_back((folder / "pid").string());
  fitted(spec).reset();
  int process = 0;
  std::ifstream(folder / "pid") >> process;
  ASSERT_GT(process, 1);
  EXPECT_NE(::kill(process, 0), 0) << "has outlived the solver";
}

TEST(CommandSolver, MeasuresItsPipe) {
  const auto solver = fitted(program_of("plain"));
  const std::unique_ptr<Solver> transport = solver->transport();
  ASSERT_NE(transport, nullptr);
  const Reconstruction out = reconstruct(*transport, random_changes(130));
  EXPECT_TRUE((out.images.array() == 0).all());
  EXPECT_EQ(fitted({{"type", "tsvd"}, {"rank", 3}})->transport(), nullptr);
}

TEST(CommandSolver, RefusesWhatIsNoCommand) {
  const auto message = [](const json& change) {
    return message_of<InputError>([&] { make_solver(program_of("plain", change)); });
  };
  EXPECT_EQ(message({{"command", "python3"}}).find("spec.json: /command: must be a list of words"),
            0u);
  EXPECT_EQ(message({{"command", json::array()}}).find("spec.json: /command: must be"), 0u);
  EXPECT_EQ(
      message({{"command", {"./absent"}}}).find("spec.json: /command: ./absent is no program"), 0u);
  EXPECT_EQ(message({{"files", {"absent.py"}}}).find("spec.json: /files: absent.py is no file"),
            0u);
  EXPECT_EQ(message({{"parameters", 3}}).find("spec.json: /parameters: must be an object"), 0u);
  EXPECT_EQ(message({{"frame_limit_s", 0}}).find("spec.json: /frame_limit_s: must be"), 0u);
}

}  // namespace
}  // namespace ertbench
