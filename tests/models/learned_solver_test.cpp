// What every solver promises (solvers/solver.h), for the learned ones, through the plugin.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "core/errors.h"
#include "tests/models/models_testing.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;
using ::testing::HasSubstr;

const json specs[] = {
    {{"type", "fcnn"}, {"widths", {64, 32}}},
    {{"type", "dcnn"}, {"widths", {8, 8, 16}}},
    {{"type", "eit-nn"}, {"dense_widths", {64, 576}}, {"channels", {4, 4}}},
    {{"type", "dd-ert"}, {"width", 4}, {"convolutions", 1}, {"discriminator_widths", {4, 8}}},
    {{"type", "dd-ert"}, {"width", 4}, {"attention_form", "self"}, {"alpha", 0}},  // has no plan
    {{"type", "lean-net"}, {"width", 4}, {"bottom_blocks", 1}},
};

json with_budget(json spec) {
  spec["epochs"] = 2;
  spec["batch"] = 16;
  return spec;
}

class LearnedContract : public ::testing::TestWithParam<json> {
 protected:
  static std::unique_ptr<Solver> trained(const TrainingFiles& files) {
    std::unique_ptr<Solver> solver = make_learned(with_budget(GetParam()));
    solver->fit(files.input());
    return solver;
  }

  TrainingFiles files_;
};

TEST_P(LearnedContract, ABatchIsTheSameAsItsFrames) {
  const auto solver = trained(files_);
  const Frames changes = random_changes(100);
  const Reconstruction batch = reconstruct(*solver, changes);
  EXPECT_TRUE(batch.images.allFinite());
  for (Eigen::Index f = 0; f < changes.rows(); f += 33) {
    const Images single = reconstruct(*solver, changes.row(f)).images;
    EXPECT_LE((single - batch.images.row(f)).norm(), 1e-5 * single.norm());
  }
}

TEST_P(LearnedContract, TwoThreadsMayShareIt) {
  const auto solver = trained(files_);
  const Frames changes = random_changes(70);
  const Reconstruction alone = reconstruct(*solver, changes);
  Reconstruction first;
  Reconstruction second;
  std::thread a([&] { first = reconstruct(*solver, changes); });
  std::thread b([&] { second = reconstruct(*solver, changes); });
  a.join();
  b.join();
  EXPECT_EQ(first.images, alone.images);
  EXPECT_EQ(second.images, alone.images);
}

TEST_P(LearnedContract, ASavedSolverIsTheSameAgain) {
  const auto solver = trained(files_);
  const std::filesystem::path file = files_.folder() / "network.fitted";
  solver->save(file);
  const auto again = make_learned({{"type", GetParam()["type"]}});
  again->load(file, Sensor{});
  EXPECT_EQ(again->parameters(), solver->parameters());
  const Frames changes = random_changes(5);
  EXPECT_EQ(reconstruct(*again, changes).images, reconstruct(*solver, changes).images);
  again->save(files_.folder() / "again.fitted");
  EXPECT_EQ(bytes_of(files_.folder() / "again.fitted"), bytes_of(file));

  Sensor other;
  other.drive_current = 0.01;
  EXPECT_THAT(message_of<InputError>([&] { again->load(file, other); }),
              HasSubstr("was fitted for the sensor"));
  const std::string another = GetParam()["type"] == "fcnn" ? "dcnn" : "fcnn";
  EXPECT_THAT(message_of<InputError>([&] {
                make_learned({{"type", another}})->load(file, {});
              }),
              HasSubstr("not a \"" + another + "\""));
}

TEST_P(LearnedContract, FilesThatAreNoneAreRefused) {
  const auto solver = make_learned(GetParam());
  const std::filesystem::path file = files_.folder() / "none.fitted";
  EXPECT_THAT(message_of<InputError>([&] { solver->load(file, {}); }), HasSubstr("no such file"));
  std::ofstream(file) << "not an archive";
  EXPECT_THAT(message_of<InputError>([&] { solver->load(file, {}); }),
              HasSubstr("cannot be opened as HDF5"));
  EXPECT_THAT(message_of<InputError>([&] { solver->load(files_.folder() / "train.h5", {}); }),
              HasSubstr("is not the file of a fitted solver"));
}

TEST_P(LearnedContract, NeedsItsData) {
  FitInput input = files_.input();
  input.training = nullptr;
  EXPECT_THAT(message_of<InputError>([&] { make_learned(GetParam())->fit(input); }),
              HasSubstr("needs the dataset \"train\""));
}

TEST_P(LearnedContract, BadFramesCostOnlyThemselves) {
  const auto solver = trained(files_);
  Frames changes = random_changes(3);
  const Reconstruction good = reconstruct(*solver, changes);
  changes.row(1).setConstant(std::nan(""));
  const Reconstruction one_bad = reconstruct(*solver, changes);
  EXPECT_EQ(one_bad.reports[1].status, FrameStatus::undefined);
  EXPECT_EQ(one_bad.reports[0].status, FrameStatus::ok);
  EXPECT_LE((one_bad.images.row(2) - good.images.row(2)).norm(), 1e-5 * good.images.norm());
}

TEST_P(LearnedContract, SaysWhichFramesAreNotToBeTrusted) {
  const TrainingFiles files(96, 200);
  const auto solver = trained(files);
  Frames changes = fresh_changes(200);
  const auto suspects = [&](const Solver& one, int reason) {
    int count = 0;
    for (const FrameReport& report : reconstruct(one, changes).reports) {
      count += report.status == FrameStatus::suspect && (report.reasons & reason) == reason;
    }
    return count;
  };
  EXPECT_LE(suspects(*solver, 0), 6);
  const std::filesystem::path file = files.folder() / "network.fitted";
  solver->save(file);
  const auto again = make_learned({{"type", GetParam()["type"]}});
  again->load(file, Sensor{});
  const auto unchecked = make_learned({{"type", GetParam()["type"]}, {"inference_check", false}});
  unchecked->load(file, Sensor{});
  for (Eigen::Index f = 0; f < changes.rows(); ++f) read_zero(changes.row(f), 1u << f % 16);
  for (const Solver* one : {solver.get(), again.get()}) {
    EXPECT_EQ(suspects(*one, dead_electrode), 200);
  }
  EXPECT_EQ(suspects(*unchecked, 0), 0);
  changes = fresh_changes(200, 30);
  EXPECT_EQ(suspects(*again, noise), 200);
}

TEST_P(LearnedContract, LoadsNetworksFromBeforeFramesWereJudged) {
  const std::string type = GetParam()["type"];
  if (type == "lean-net") GTEST_SKIP() << "came later";
  const auto solver = make_learned({{"type", type}});
  solver->load(ERTBENCH_SOURCE_DIR "/results/baselines/networks/" + type + ".fitted", Sensor{});
  Frames changes = fresh_changes(2, 20);
  read_zero(changes.row(1), 1u << 3);
  const Reconstruction out = reconstruct(*solver, changes);
  EXPECT_EQ(out.reports[0].status, FrameStatus::ok);
  EXPECT_EQ(out.reports[1].status, FrameStatus::suspect);
}

TEST_P(LearnedContract, IsTrainedWithFaults) {
  json spec = with_budget(GetParam());
  spec["training_faults"] = {{"dead_electrodes", {0, 4}}, {"gain_error", {0, 0.05}}};
  const auto solver = make_learned(spec);
  solver->fit(files_.input());
  EXPECT_EQ(solver->parameters().at("fault_share"), 0.5);
  EXPECT_EQ(solver->parameters().at("training_faults").at("dead_electrodes"), json({0, 4}));
  EXPECT_FALSE(trained(files_)->parameters().contains("training_faults"));
  const std::filesystem::path file = files_.folder() / "network.fitted";
  solver->save(file);
  const auto again = make_learned({{"type", GetParam()["type"]}});
  again->load(file, Sensor{});
  EXPECT_EQ(again->parameters(), solver->parameters());
}

TEST_P(LearnedContract, ImagesEidorsFrames) {
  const auto solver = trained(files_);
  const Reconstruction out = reconstruct(*solver, eidors_changes());
  EXPECT_TRUE(out.images.allFinite());
}

INSTANTIATE_TEST_SUITE_P(All, LearnedContract, ::testing::ValuesIn(specs), [](const auto& test) {
  std::string name = test.param.at("type");
  name.erase(std::remove(name.begin(), name.end(), '-'), name.end());
  if (test.param.contains("attention_form")) name += "Self";
  return name;
});

// At a rate of nothing the loss of the log is that of the first images.
TEST(LearnedSolver, TrainsOnTheLossThatItIsAskedFor) {
  const TrainingFiles files(96, 40);
  const auto first_loss = [&](json spec, const char* key, const char* loss) {
    spec[key] = loss;
    spec["learning_rate"] = 1e-12;
    FitInput input = files.input();
    const TemporaryFolder folder("loss");
    input.work_folder = folder / "";
    make_learned(with_budget(spec))->fit(input);
    std::ifstream log(folder / "training.csv");
    std::string line;
    std::getline(log, line);
    std::getline(log, line);
    return std::stod(line.substr(line.find(',') + 1));
  };
  for (json spec : specs) {
    const bool dd_ert = spec["type"] == "dd-ert";
    if (dd_ert) spec["alpha"] = spec["beta"] = 0;
    const char* const key = dd_ert ? "content_loss" : "loss";
    // The images begin at nothing like the truths: their relative error is of the size of one.
    EXPECT_GT(first_loss(spec, key, "relative"), 2 * first_loss(spec, key, "mse")) << spec;
  }
}

TEST(LearnedSolverSettings, AreCheckedWithTheirPlace) {
  const auto said = [](const json& spec) {
    return message_of<InputError>([&] { make_learned(spec)->check(Sensor{}); });
  };
  EXPECT_THAT(said({{"type", "dd-ert"}, {"alpha", -1}}), HasSubstr("spec.json: /alpha"));
  EXPECT_THAT(said({{"type", "dd-ert"}, {"initialisation", "physic"}}), HasSubstr("\"physics\""));
  EXPECT_THAT(said({{"type", "dd-ert"}, {"label_smoothing", 0.5}}), HasSubstr("/label_smoothing"));
  EXPECT_THAT(said({{"type", "dd-ert"}, {"instance_noise", -1}}), HasSubstr("/instance_noise"));
  EXPECT_THAT(said({{"type", "fcnn"}, {"width", 3}}), HasSubstr("/width"));
  EXPECT_THAT(said({{"type", "fcnn"}, {"batch", 1}}), HasSubstr("/batch"));
  EXPECT_THAT(said({{"type", "dcnn"}, {"widths", {8, 8}}}), HasSubstr("/widths"));
  EXPECT_THAT(said({{"type", "eit-nn"}, {"dense_widths", {64, 32}}}), HasSubstr("576"));
  Sensor coarse;
  coarse.image_grid = 12;
  EXPECT_EQ(message_of<InputError>([&] {
              make_learned({{"type", "eit-nn"}})->check(coarse);
            }),
            "")
      << "the default ends in the pixels of any sensor";
  EXPECT_THAT(
      message_of<InputError>([&] {
        make_learned({{"type", "eit-nn"}, {"dense_widths", {2304, 576, 576}}})->check(coarse);
      }),
      HasSubstr("must end in 144, the sensor's pixels, not in 576"))
      << "widths that the user gives are kept, even those of the default";
  EXPECT_EQ(said({{"type", "dd-ert"}, {"alpha", 100}, {"beta", 100}}), "");
  EXPECT_THAT(said({{"type", "fcnn"}, {"fault_share", 0.5}}), HasSubstr("/fault_share"));
  EXPECT_THAT(said({{"type", "fcnn"}, {"training_faults", json::object()}}),
              HasSubstr("/training_faults: has no fault"));
  EXPECT_THAT(said({{"type", "fcnn"}, {"training_faults", {{"adc_bits", 8}}}}),
              HasSubstr("/training_faults/adc_bits"));
}

class NetworkWithAFront : public ::testing::TestWithParam<json> {};

TEST_P(NetworkWithAFront, ReadsNothingFromDeadElectrodes) {
  const TrainingFiles files(96, 120);
  json spec = with_budget(GetParam());
  spec["front"] = true;
  spec["training_faults"] = {{"dead_electrodes", {0, 4}},
                             {"level", {-0.1, 0.1}},
                             {"gradient", {0, 0.2}},
                             {"displacement", {0, 0.02}},
                             {"snr_db", {35, 65}}};
  const auto solver = make_learned(spec);
  solver->fit(files.input());
  EXPECT_EQ(solver->parameters().at("training_faults"), [&] {
    json all = spec["training_faults"];
    all.update({{"dead_reading", "zero"}, {"gain_error", {0, 0}}, {"offset", {0, 0}}});
    return all;
  }());
  Frames changes = fresh_changes(3);
  const Reconstruction sound = reconstruct(*solver, changes);
  RandomStream random(1, 0, 0, Purpose::scene);
  for (Eigen::Index f = 0; f < 3; ++f) read_zero(changes.row(f), 1u << 4);
  const Reconstruction zero = reconstruct(*solver, changes);
  for (Eigen::Index f = 0; f < 3; ++f) read_noise(changes.row(f), 1u << 4, random);
  const Reconstruction floating = reconstruct(*solver, changes);
  EXPECT_EQ(zero.reports[0].dead, ElectrodeSet{1} << 4);
  EXPECT_EQ(zero.reports[0].status, FrameStatus::ok) << "it may be trusted";
  EXPECT_LT(relative_difference(floating.images, zero.images), 1e-6);
  EXPECT_GT(relative_difference(zero.images, sound.images), 1e-4);

  solver->save(files.folder() / "network.fitted");
  const auto again = make_learned({{"type", spec["type"]}});
  again->load(files.folder() / "network.fitted", Sensor{});
  EXPECT_EQ(again->parameters(), solver->parameters());
  EXPECT_EQ(reconstruct(*again, changes).images, floating.images);
  const Reconstruction alone = reconstruct(*again, changes.topRows(1));
  EXPECT_LT(relative_difference(alone.images, floating.images.topRows(1)), 1e-4);
}

// Noise and level as in training are usual, to a network without training faults they are not. Two
// frames in a hundred may be flagged by chance.
TEST_P(NetworkWithAFront, FlagsFramesBeyondTheFaultsOfItsTraining) {
  const TrainingFiles files(96, 400);
  json spec = with_budget(GetParam());
  spec["front"] = true;
  spec["fault_share"] = 1;
  spec["training_faults"] = {{"level", {-0.1, 0.1}}, {"snr_db", {40, 50}}};
  const auto solver = make_learned(spec);
  solver->fit(files.input());
  const auto flagged = [](const Solver& by, const Frames& changes) {
    int out = 0;
    for (const FrameReport& report : reconstruct(by, changes).reports) {
      out += report.status == FrameStatus::suspect;
    }
    return out;
  };
  const Eigen::RowVectorXd reference = uniform_reference({}).transpose();
  const auto of_level = [&](double level) {
    return Frames(((fresh_changes(100, 42).rowwise() + reference) / (1 + level)).rowwise() -
                  reference);
  };
  EXPECT_LE(flagged(*solver, of_level(0)), 2);
  EXPECT_LE(flagged(*solver, of_level(0.08)), 4);
  EXPECT_LE(flagged(*solver, of_level(-0.08)), 4);
  EXPECT_GE(flagged(*solver, fresh_changes(100, 34)), 90);
  const auto unaware = make_learned(with_budget(GetParam()));
  unaware->fit(files.input());
  EXPECT_GE(flagged(*unaware, of_level(-0.08)), 90);

  solver->save(files.folder() / "network.fitted");
  const auto again = make_learned({{"type", spec["type"]}});
  again->load(files.folder() / "network.fitted", Sensor{});
  EXPECT_EQ(flagged(*again, of_level(0.08)), flagged(*solver, of_level(0.08)));
  EXPECT_EQ(flagged(*again, fresh_changes(100, 34)), flagged(*solver, fresh_changes(100, 34)));
}

INSTANTIATE_TEST_SUITE_P(
    All, NetworkWithAFront,
    ::testing::Values(json{{"type", "lean-net"}, {"width", 4}, {"bottom_blocks", 1}},
                      json{{"type", "dd-ert"}, {"width", 4}, {"convolutions", 1}},
                      json{{"type", "fcnn"}, {"widths", {32}}}),
    [](const auto& info) {
      return info.index == 0 ? "LeanNet" : info.index == 1 ? "DdErt" : "Fcnn";
    });

/// A training that changes nothing shows what it started from: what only the new network is told
/// weighs nothing.
TEST(LeanNetWithAFront, StartsFromTheWeightsOfOneWithout) {
  const TrainingFiles files(96, 120);
  json spec = with_budget({{"type", "lean-net"}, {"width", 4}, {"bottom_blocks", 1}});
  const auto plain = make_learned(spec);
  plain->fit(files.input());
  plain->save(files.folder() / "plain.fitted");
  spec["front"] = true;
  spec["start_from"] = (files.folder() / "plain.fitted").string();
  spec["learning_rate"] = 1e-12;
  spec["freeze_statistics"] = 0;
  const auto told = make_learned(spec);
  told->fit(files.input());
  const Frames changes = fresh_changes(3);
  EXPECT_LT(
      relative_difference(reconstruct(*told, changes).images, reconstruct(*plain, changes).images),
      1e-4);
  spec["width"] = 5;
  const auto wider = make_learned(spec);
  EXPECT_THROW(wider->fit(files.input()), InputError);
}

TEST(LearnedSolverSettings, OfTheAdversarialGameAreKeptWithTheNetwork) {
  const TrainingFiles files;
  json spec = with_budget(specs[3]);
  const auto plain = make_learned(spec);
  for (const char* name : {"spectral_norm", "instance_noise", "label_smoothing"}) {
    EXPECT_FALSE(plain->parameters().contains(name));  // as in files from before there were these
  }
  spec.update({{"spectral_norm", true}, {"instance_noise", 0.1}, {"label_smoothing", 0.2}});
  const auto solver = make_learned(spec);
  solver->fit(files.input());
  solver->save(files.folder() / "network.fitted");
  const auto again = make_learned({{"type", "dd-ert"}});
  again->load(files.folder() / "network.fitted", Sensor{});
  EXPECT_EQ(again->parameters(), solver->parameters());
  EXPECT_EQ(again->parameters().at("spectral_norm"), true);
  EXPECT_EQ(again->parameters().at("label_smoothing"), 0.2);
}

TEST(LearnedSolverSettings, HugeWeightsEndOneWayOrTheOther) {
  const TrainingFiles files;
  json spec = with_budget(specs[3]);
  spec["alpha"] = 100;
  spec["beta"] = 100;
  const auto solver = make_learned(spec);
  solver->fit(files.input());
  EXPECT_TRUE(reconstruct(*solver, random_changes(3)).images.allFinite());
}

}  // namespace
}  // namespace ertbench
