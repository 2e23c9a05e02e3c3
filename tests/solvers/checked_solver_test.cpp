#include "solvers/check/checked_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "core/errors.h"
#include "core/hdf5_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/channel_mask.h"
#include "solvers/registry/registry.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// What a test's solver does, and what it was asked for.
struct Behaviour {
  Eigen::Index block = 0;
  bool detect = false;
  ElectrodeSet masked = 0;
  json parameters = json::object();
  FitReport report = {};
  /// Writes and reads the file of the solver; by default it saves nothing.
  std::function<void(const std::filesystem::path&)> save = [](const auto&) {};
  std::function<void(const std::filesystem::path&)> load = [](const auto&) {};
  std::function<void(ImagesView, std::span<FrameReport>)> image = [](ImagesView images, auto) {
    images.setConstant(-1);
  };
  int fits = 0;
  std::vector<Eigen::Index> blocks;  ///< frames of each call
  std::vector<ElectrodeSet> dead;    ///< of each frame, as the solver was told
  Frames frames;                     ///< of the last call
};

class Puppet final : public Solver {
 public:
  explicit Puppet(Behaviour& behaviour) : behaviour_(behaviour) {}
  json parameters() const override { return behaviour_.parameters; }
  FitReport fit_report() const override { return behaviour_.report; }
  void fit(const FitInput&) override { ++behaviour_.fits; }
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override {
    behaviour_.blocks.push_back(changes.rows());
    behaviour_.frames = changes;
    for (const FrameReport& report : reports) behaviour_.dead.push_back(report.dead);
    behaviour_.image(images, reports);
  }
  Eigen::Index block_frames() const override { return behaviour_.block; }
  MaskedChannels masked_channels() const override { return {behaviour_.masked, behaviour_.detect}; }
  void save(const std::filesystem::path& file) const override { behaviour_.save(file); }
  void load(const std::filesystem::path& file, const Sensor&) override { behaviour_.load(file); }

 private:
  Behaviour& behaviour_;
};

std::unique_ptr<Solver> make_puppet(Behaviour& behaviour, json spec = json::object(),
                                    const std::string& type = "puppet") {
  SolverInfo info;
  info.make = [&](JsonObject object) -> std::unique_ptr<Solver> {
    object.finish();
    return std::make_unique<Puppet>(behaviour);
  };
  SolverRegistry registry;
  registry.add(type, info);
  spec["type"] = type;
  return registry.make(JsonObject(spec, "spec.json", ""));
}

std::unique_ptr<Solver> fitted_puppet(Behaviour& behaviour, json spec = json::object()) {
  static const ValidationFile validation(300);
  std::unique_ptr<Solver> solver = make_puppet(behaviour, std::move(spec));
  solver->fit(validation.input());
  return solver;
}

TEST(CheckedSolver, WhatTheSolverSaysIsPrintable) {
  Behaviour behaviour;
  behaviour.parameters = {{"a\xff", {"\x1b[31m", 1.5}}};
  behaviour.report = {"bad\x1b", "\xff" + std::string(5000, 'x'), 2.0};
  const auto solver = make_puppet(behaviour);
  EXPECT_EQ(solver->parameters().at("a\ufffd"), json({"\ufffd[31m", 1.5}));
  const FitReport report = solver->fit_report();
  EXPECT_EQ(report.status, "bad\ufffd");
  EXPECT_EQ(report.message, "\ufffd" + std::string(999, 'x') + "…");
  EXPECT_EQ(report.earlier_s, 2.0);
}

TEST(CheckedSolver, GivesFramesInBlocksOfTheSolversSize) {
  Behaviour behaviour;
  behaviour.block = 16;
  const Frames changes = fresh_changes(40);
  const auto solver = fitted_puppet(behaviour);
  EXPECT_TRUE((reconstruct(*solver, changes).images.array() == -1).all());
  EXPECT_EQ(behaviour.blocks, (std::vector<Eigen::Index>{16, 16, 8}));
  behaviour.blocks.clear();
  behaviour.block = 0;
  reconstruct(*solver, changes);
  EXPECT_EQ(behaviour.blocks, std::vector<Eigen::Index>{40});
}

TEST(CheckedSolver, TakesNuisancesOutOfFrames) {
  Behaviour behaviour;
  const auto solver = fitted_puppet(behaviour, {{"inference_nuisances", {{"level", 0.1}}}});
  EXPECT_EQ(solver->parameters().at("inference_nuisances").at("level"), 0.1);
  const Frames changes = fresh_changes(1) * 0 + Frames(uniform_reference({}).transpose() / 20);
  reconstruct(*solver, changes);
  EXPECT_LT(behaviour.frames.norm(), 0.2 * changes.norm());
  reconstruct(*fitted_puppet(behaviour), changes);
  EXPECT_EQ(behaviour.frames, changes);
}

TEST(CheckedSolver, JudgesTheFramesOfASolverThatKnowsNothingOfIt) {
  Behaviour behaviour;
  behaviour.block = 16;
  Frames changes = fresh_changes(40);
  read_zero(changes.row(20), 1u << 4);
  changes.row(39) *= 20;  // the noise with the rest
  const Reconstruction out = reconstruct(*fitted_puppet(behaviour), changes);
  EXPECT_EQ(out.reports[20].status, FrameStatus::suspect);
  EXPECT_EQ(out.reports[20].reasons, dead_electrode);
  EXPECT_EQ(out.reports[20].dead, ElectrodeSet{1} << 4);
  EXPECT_EQ(out.reports[39].status, FrameStatus::suspect);
  EXPECT_EQ(out.reports[39].reasons, noise);
  EXPECT_EQ(out.reports[3].status, FrameStatus::ok);
  EXPECT_EQ(behaviour.dead, std::vector<ElectrodeSet>(40, 0)) << "it did not ask for them";

  const auto unchecked = fitted_puppet(behaviour, {{"inference_check", false}});
  EXPECT_EQ(unchecked->parameters(), (json{{"inference_check", false}}));
  for (const FrameReport& report : reconstruct(*unchecked, changes).reports) {
    EXPECT_EQ(report.status, FrameStatus::ok);
    EXPECT_EQ(report.reasons, 0);
  }
}

TEST(CheckedSolver, ImputesTheChannelsOfDeadElectrodesForASolverThatDoesNotMaskThem) {
  Behaviour behaviour;
  const std::unique_ptr<Solver> solver = fitted_puppet(behaviour);
  Frames changes = fresh_changes(4);
  const Frames sound = changes;
  read_zero(changes.row(1), 1u << 4);
  read_zero(changes.row(2), 1u << 4 | 1u << 9 | 1u << 13);
  const Reconstruction out = reconstruct(*solver, changes);
  EXPECT_EQ(out.reports[1].status, FrameStatus::suspect);
  EXPECT_EQ(out.reports[1].reasons, dead_electrode);
  ASSERT_EQ(behaviour.frames.rows(), 4);
  EXPECT_EQ(behaviour.frames.row(0), sound.row(0));
  EXPECT_EQ(behaviour.frames.row(3), sound.row(3));
  const auto error = [&](Eigen::Index f) { return (behaviour.frames - sound).row(f).norm(); };
  EXPECT_LT(error(1), (changes - sound).row(1).norm() / 10);
  EXPECT_LT(error(2), (changes - sound).row(2).norm() / 10);
  reconstruct(*fitted_puppet(behaviour, {{"inference_imputation", false}}), changes);
  EXPECT_EQ(behaviour.frames, changes);
}

TEST(CheckedSolver, TellsASolverThatAsksWhichElectrodesAreDead) {
  Behaviour behaviour;
  behaviour.detect = true;
  behaviour.block = 2;
  Frames changes = fresh_changes(5);
  read_zero(changes.row(3), 1u << 2 | 1u << 7);
  read_zero(changes.row(4), 0x1249);  // 0, 3, 6, 9 and 12: more than are masked without a word
  for (const bool check : {true, false}) {
    behaviour.dead.clear();
    const Reconstruction out =
        reconstruct(*fitted_puppet(behaviour, {{"inference_check", check}}), changes);
    ASSERT_EQ(behaviour.dead.size(), 5u);
    EXPECT_EQ(behaviour.dead[2], 0u);
    EXPECT_EQ(behaviour.dead[3], 1u << 2 | 1u << 7);
    EXPECT_EQ(behaviour.dead[4] & 0x1249, 0x1249u);
    EXPECT_EQ(out.reports[3].status, FrameStatus::ok);
    EXPECT_EQ(out.reports[3].reasons, check ? dead_electrode : 0);
    EXPECT_EQ(out.reports[4].status, check ? FrameStatus::suspect : FrameStatus::ok);
  }
}

// A solver that leaves out dead electrodes would throw away what a loose one still reads.
TEST(CheckedSolver, MendsWhatALooseContactLosesForASolverThatMasks) {
  const ValidationFile validation(400);
  const nlohmann::json spec = {
      {"type", "one-step-gn"}, {"prior", "noser"}, {"lambda", 0.1}, {"channel_mask", "detect"}};
  const auto solver = SolverRegistry().make(JsonObject(spec, "test", ""));
  solver->fit(validation.input());
  const Eigen::VectorXd reference = uniform_reference({});
  const auto electrodes = electrode_sets_of_channels(Sensor{});
  const Frames sound = fresh_changes(20);
  Frames torn = sound;
  Frames dead = sound;
  RandomStream random(6, 0, 0, Purpose::scene);
  for (Eigen::Index f = 0; f < torn.rows(); ++f) {
    for (Eigen::Index c = 0; c < torn.cols(); ++c) {
      if (!(electrodes[static_cast<std::size_t>(c)] >> (f % 16) & 1)) continue;
      dead(f, c) = -reference[c];
      if (random.uniform() < 0.5) torn(f, c) = -reference[c];
    }
  }
  const Images images = reconstruct(*solver, sound).images;
  const Reconstruction mended = reconstruct(*solver, torn);
  EXPECT_LT((mended.images - images).norm(),
            0.6 * (reconstruct(*solver, dead).images - images).norm());
  for (const FrameReport& report : mended.reports) EXPECT_EQ(report.status, FrameStatus::ok);
}

TEST(CheckedSolver, TheSolversOwnStatusTakesPrecedence) {
  Behaviour behaviour;
  behaviour.image = [](ImagesView images, std::span<FrameReport> reports) {
    images.setZero();
    reports[0].status = FrameStatus::not_converged;
    reports[1].status = FrameStatus::undefined;
    reports[2].status = FrameStatus::ok;
  };
  Frames changes = fresh_changes(3);
  for (int f = 0; f < 3; ++f) read_zero(changes.row(f), 1u << 4);
  const Reconstruction out = reconstruct(*fitted_puppet(behaviour), changes);
  // That an iteration came to no end is what dead electrodes did.
  EXPECT_EQ(out.reports[0].status, FrameStatus::suspect);
  EXPECT_EQ(out.reports[0].reasons, dead_electrode);
  EXPECT_EQ(out.reports[1].status, FrameStatus::undefined);
  EXPECT_EQ(out.reports[1].reasons, 0);
  EXPECT_EQ(out.reports[2].status, FrameStatus::suspect);
}

TEST(CheckedSolver, WhatIsNotFiniteIsUndefined) {
  Behaviour behaviour;
  Frames changes = fresh_changes(5);
  behaviour.image = [](ImagesView images, auto) {
    images.setZero();
    images(2, 575) = std::numeric_limits<double>::quiet_NaN();
    images(3, 0) = std::numeric_limits<double>::infinity();
  };
  changes(4, 17) = -std::numeric_limits<double>::infinity();  // of which the image is finite
  const Reconstruction out = reconstruct(*fitted_puppet(behaviour), changes);
  for (const std::size_t f : {2, 3, 4}) EXPECT_EQ(out.reports[f].status, FrameStatus::undefined);
  for (const std::size_t f : {0, 1}) EXPECT_EQ(out.reports[f].status, FrameStatus::ok);
}

TEST(CheckedSolver, WhatMaskedChannelsReadDoesNotMatterAndOthersDo) {
  Behaviour behaviour;
  behaviour.masked = 1U << 3;
  Frames changes = fresh_changes(3);
  const std::vector<ElectrodeSet> electrodes = electrodes_of_pairs(Sensor{});
  const auto pairs = reciprocal_pairs(Sensor{});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if ((electrodes[p] & behaviour.masked) != 0) changes(1, pairs[p][0]) = nan;
  }
  const auto taken = std::find_if(electrodes.begin(), electrodes.end(),
                                  [&](ElectrodeSet set) { return (set & behaviour.masked) == 0; });
  changes(2, pairs[static_cast<std::size_t>(taken - electrodes.begin())][1]) = nan;
  const Reconstruction out = reconstruct(*fitted_puppet(behaviour), changes);
  EXPECT_NE(out.reports[0].status, FrameStatus::undefined);
  EXPECT_NE(out.reports[1].status, FrameStatus::undefined);
  EXPECT_EQ(out.reports[2].status, FrameStatus::undefined);
}

TEST(CheckedSolver, RefusesDatasetsOfAnotherSensor) {
  const TemporaryFolder folder;
  Sensor other;
  other.background *= 2;
  generate_dataset(random_contacts(20, other), folder / "other.h5");
  const DatasetFile training(folder / "other.h5");
  static const ValidationFile validation(300);
  Behaviour behaviour;
  FitInput input = validation.input();
  input.training = &training;
  EXPECT_THROW(make_puppet(behaviour)->fit(input), InputError);
  EXPECT_EQ(behaviour.fits, 0);
}

TEST(CheckedSolver, RefusesCallsThatBreakTheContract) {
  Behaviour behaviour;
  const auto solver = make_puppet(behaviour);
  const TemporaryFolder folder;
  EXPECT_THROW(reconstruct(*solver, fresh_changes(1)), std::logic_error);
  EXPECT_THROW(solver->save(folder / "solver.fitted"), std::logic_error);
  solver->fit(FitInput{});
  std::vector<FrameReport> reports(2);
  Images images(2, 576);
  EXPECT_NO_THROW(solver->reconstruct(Frames::Zero(2, 208), images, reports));
  EXPECT_THROW(solver->reconstruct(Frames::Zero(2, 207), images, reports), std::logic_error);
  EXPECT_THROW(solver->reconstruct(Frames::Zero(1, 208), images, reports), std::logic_error);
  reports.pop_back();
  EXPECT_THROW(solver->reconstruct(Frames::Zero(2, 208), images, reports), std::logic_error);
  EXPECT_EQ(behaviour.blocks.size(), 1u);
}

/// The three kinds of files that a solver may save: none, HDF5, and anything else.
class CheckedFileOf : public ::testing::TestWithParam<const char*> {
 protected:
  CheckedFileOf() {
    const std::string kind = GetParam();
    if (kind == "hdf5" || kind == "hdf5 with a check of its own") {
      const std::string name = kind == "hdf5" ? "/numbers" : "/frame_check";
      behaviour_.save = [=](const auto& file) {
        Hdf5File::create(file).write_vector(name, Eigen::VectorXd::Constant(3, 7));
      };
      behaviour_.load = [this, name](const auto& file) {
        found_ = Hdf5File::open(file).read_vector(name).sum() == 21;
      };
    } else if (kind == "bytes" || kind == "an empty file") {
      // Longer than what is copied at a time, and every byte there is.
      std::string content;
      while (kind == "bytes" && content.size() < 1500000) {
        for (int byte = 0; byte < 256; ++byte) content += static_cast<char>(byte);
      }
      behaviour_.save = [=](const auto& file) { std::ofstream(file, std::ios::binary) << content; };
      behaviour_.load = [this, content](const auto& file) {
        std::ifstream in(file, std::ios::binary);
        found_ = std::string(std::istreambuf_iterator<char>(in), {}) == content;
      };
    } else {
      behaviour_.load = [this](const auto& file) { found_ = !std::filesystem::exists(file); };
    }
  }

  Behaviour behaviour_;
  bool found_ = false;  ///< by `load`, what `save` wrote
  TemporaryFolder folder_;
};

TEST_P(CheckedFileOf, HoldsTheSolversOwnAndTheCheck) {
  const auto solver = fitted_puppet(behaviour_);
  Frames changes = fresh_changes(10, 30);
  const Reconstruction before = reconstruct(*solver, changes);
  EXPECT_EQ(before.reports[0].reasons & noise, noise) << "which takes a fitted check to see";
  solver->save(folder_ / "solver.fitted");
  const auto again = make_puppet(behaviour_);
  again->load(folder_ / "solver.fitted", Sensor{});
  EXPECT_TRUE(found_);
  const Reconstruction after = reconstruct(*again, changes);
  for (std::size_t f = 0; f < before.reports.size(); ++f) {
    EXPECT_EQ(after.reports[f].reasons, before.reports[f].reasons);
  }
  // It is one file.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_ / ""), {}), 1);
}

TEST_P(CheckedFileOf, IsRefusedForAnotherTypeOrSensor) {
  fitted_puppet(behaviour_)->save(folder_ / "solver.fitted");
  const auto refusal = [&](const std::string& type, const Sensor& sensor) {
    return message_of<InputError>([&] {
      make_puppet(behaviour_, json::object(), type)->load(folder_ / "solver.fitted", sensor);
    });
  };
  EXPECT_NE(refusal("other", Sensor{}).find("holds a fitted \"puppet\", not a \"other\""),
            std::string::npos);
  Sensor sensor;
  sensor.background = 0.05;
  EXPECT_NE(refusal("puppet", sensor).find("was fitted for the sensor"), std::string::npos);
  EXPECT_FALSE(found_);
}

INSTANTIATE_TEST_SUITE_P(Kinds, CheckedFileOf,
                         ::testing::Values("nothing", "hdf5", "hdf5 with a check of its own",
                                           "bytes", "an empty file"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(CheckedFile, SaysWhatIsDamaged) {
  Behaviour behaviour;
  const TemporaryFolder folder;
  const auto solver = fitted_puppet(behaviour);
  behaviour.save = [](const auto& file) {
    Hdf5File::create(file).write_vector("/numbers", Eigen::VectorXd::Zero(1));
  };
  solver->save(folder / "solver.fitted");
  {
    const Eigen::VectorXd numbers =
        Hdf5File::open(folder / "solver.fitted").read_vector("/frame_check");
    Hdf5File damaged = Hdf5File::create(folder / "damaged.fitted");
    damaged.write_text("/", "solver", "puppet");
    damaged.write_text("/", "sensor", to_json(Sensor{}).dump());
    damaged.write_vector("/frame_check", numbers.head(numbers.size() - 1));
  }
  const std::string message = message_of<InputError>(
      [&] { make_puppet(behaviour)->load(folder / "damaged.fitted", Sensor{}); });
  EXPECT_NE(message.find("damaged.fitted: /frame_check: the frame check is damaged"),
            std::string::npos)
      << message;
}

/// Files that the program wrote when every solver still kept its own check, with the parameters of
/// inference among the others: TSVD of rank 16 without averaging, and PDIPM without electrode 3,
/// fitted with 300 validation frames.
class OlderFit : public ::testing::TestWithParam<const char*> {
 protected:
  static std::filesystem::path file() {
    return ERTBENCH_TEST_DATA "/older_fits/" + std::string(GetParam()) + ".fitted";
  }
};

TEST_P(OlderFit, IsLoadedWithItsCheck) {
  const auto solver = make_solver({{"type", GetParam()}});
  solver->load(file(), Sensor{});
  const json parameters = solver->parameters();
  EXPECT_EQ(parameters.at("inference_check"), true);
  const bool tsvd = GetParam() == std::string("tsvd");
  if (tsvd) {
    EXPECT_EQ(parameters.at("rank"), 16);
    EXPECT_EQ(parameters.at("inference_averaging"), true) << "this solver's, not the file's";
  } else {
    EXPECT_EQ(parameters.at("channel_mask"), json({3}));
  }
  // Good frames, noisy ones, and dead electrodes.
  Frames changes = fresh_changes(12);
  changes.middleRows(4, 4) = fresh_changes(4, 30);
  for (int f = 8; f < 12; ++f) read_zero(changes.row(f), 1u << f);
  const Reconstruction out = reconstruct(*solver, changes);
  for (std::size_t f = 0; f < 12; ++f) {
    EXPECT_EQ(out.reports[f].status, f < 4 ? FrameStatus::ok : FrameStatus::suspect) << f;
    EXPECT_EQ(out.reports[f].reasons, f < 4 ? 0 : f < 8 ? noise : dead_electrode) << f;
  }
  // What the older program made of the first frame.
  const double expected[] = {tsvd ? 8.5994736459076221e-05 : 0.0013878650502472546,
                             tsvd ? -0.00081714674184341779 : -0.056901175524062847};
  const double tolerance = tsvd ? 1e-12 : 1e-5;
  EXPECT_NEAR(out.images(0, 0), expected[0], tolerance);
  EXPECT_NEAR(out.images(0, 300), expected[1], tolerance);
}

TEST_P(OlderFit, IsLaidOutAsFilesStillAre) {
  const auto solver = make_solver({{"type", GetParam()}});
  solver->load(file(), Sensor{});
  const TemporaryFolder folder;
  solver->save(folder / "again.fitted");
  const Hdf5File before = Hdf5File::open(file());
  const Hdf5File after = Hdf5File::open(folder / "again.fitted");
  EXPECT_EQ(after.read_vector("/frame_check"), before.read_vector("/frame_check"));
  for (const char* name : {"solver", "sensor"}) {
    EXPECT_EQ(after.read_text("/", name), before.read_text("/", name));
  }
  EXPECT_EQ(after.read_number("/", "format_version"), before.read_number("/", "format_version"));
}

INSTANTIATE_TEST_SUITE_P(All, OlderFit, ::testing::Values("tsvd", "pdipm"),
                         [](const auto& instance) { return std::string(instance.param); });

}  // namespace
}  // namespace ertbench
