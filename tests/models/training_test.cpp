// Training: repeatable bit for bit, resumable, honest about divergence.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <fstream>

#include "core/errors.h"
#include "forward/border/border_model.h"
#include "forward/fem/forward_model.h"
#include "models/networks/dd_ert_generator.h"
#include "models/networks/torch_runtime.h"
#include "models/training/objective.h"
#include "models/training/trainer.h"
#include "solvers/nuisances.h"
#include "tests/file_size_limit.h"
#include "tests/models/models_testing.h"
#include "tests/models/torch_archive.h"

namespace ertbench {
namespace {

using namespace testing;
namespace fs = std::filesystem;

TrainingSettings small_settings() {
  TrainingSettings settings;
  settings.epochs = 4;
  settings.batch = 16;
  return settings;
}

/// Everything of one training of a narrow DD-ERT, up to its weights.
struct SmallTraining {
  SmallTraining(const TrainingFiles& files, const TrainingSettings& chosen,
                AdversarialSettings game = {})
      : settings(chosen) {
    start_torch(1);
    torch::manual_seed(settings.seed);
    const FitInput input = files.input();
    const Standardisation standardisation = Standardisation::of(*input.training);
    network = std::make_shared<DdErtGenerator>(Sensor{}, GeneratorShape{.width = 4});
    game.discriminator_widths = {4, 8};
    game.bfloat16 = chosen.bfloat16;
    objective = std::make_unique<AdversarialObjective>(game);
    scenes.emplace(*input.training, standardisation, settings);
    validation.emplace(*input.validation, standardisation);
  }

  TrainingResult run(const TrainingOutlet& outlet) {
    return train(*network, *objective, *scenes, *validation, settings, outlet);
  }

  /// Of the network, with its running statistics, and of all that it was trained against.
  std::vector<double> weights() const {
    NamedTensors tensors = weights_of(*network);
    append(tensors, "objective.", objective->state());
    std::vector<double> all;
    for (const auto& [name, values] : tensors) {
      const torch::Tensor flat = values.detach().flatten().to(torch::kFloat64).contiguous();
      all.insert(all.end(), flat.data_ptr<double>(), flat.data_ptr<double>() + flat.numel());
    }
    return all;
  }

  TrainingSettings settings;
  std::shared_ptr<DdErtGenerator> network;
  std::unique_ptr<Objective> objective;
  std::optional<TrainingSet> scenes;
  std::optional<ValidationSet> validation;
};

std::vector<double> weights_after(const TrainingFiles& files, const TrainingSettings& settings,
                                  const AdversarialSettings& game = {}) {
  const TemporaryFolder folder;
  SmallTraining training(files, settings, game);
  training.run({.folder = folder / ""});
  return training.weights();
}

TEST(Training, IsTheSameBitForBit) {
  const TrainingFiles files;
  TrainingSettings settings = small_settings();
  const std::vector<double> first = weights_after(files, settings);
  EXPECT_EQ(weights_after(files, settings), first);
  settings.seed = 2;
  EXPECT_NE(weights_after(files, settings), first);
}

/// The way of a GPU, where batches are drawn on other threads while the network learns.
TEST(Training, IsTheSameWhereBatchesAreDrawnAheadOfTime) {
  const TrainingFiles files;
  const TemporaryFolder folder;
  SmallTraining training(files, small_settings());
  training.run({.folder = folder / "", .on = {.threads = 3, .ahead = true}});
  EXPECT_EQ(training.weights(), weights_after(files, small_settings()));
}

/// Settings of 32 steps at the full rate.
TrainingSettings settings_of_32_steps() {
  TrainingSettings settings = small_settings();
  settings.batch = 12;  // of 96 scenes
  settings.one_cycle = false;
  return settings;
}

TEST(Training, OnAGpuComesToTheNetworkOfTheCpu) {
  if (!torch::cuda::is_available()) GTEST_SKIP() << "libtorch finds no GPU";
  const TrainingFiles files;
  const TemporaryFolder folder;
  SmallTraining cpu(files, settings_of_32_steps());
  SmallTraining gpu(files, settings_of_32_steps());
  cpu.run({.folder = folder / ""});
  gpu.run({.folder = folder / "", .on = {training_device("cuda"), 2, true}});
  const std::vector<double> expected = cpu.weights();
  const std::vector<double> found = gpu.weights();
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_NEAR(found[i], expected[i], 1e-3 * std::max(1.0, std::abs(expected[i]))) << i;
  }
}

TEST(Training, ADeviceThatIsNotThereIsAnErrorOfTheInput) {
  EXPECT_TRUE(training_device("cpu").is_cpu());
  ::setenv("ERTBENCH_DEVICE", "cpu", 1);
  EXPECT_TRUE(training_device("auto").is_cpu());
  ::setenv("ERTBENCH_DEVICE", "tpu", 1);
  EXPECT_THAT(message_of<InputError>([] { training_device("auto"); }),
              ::testing::HasSubstr("must be auto, cpu or cuda"));
  ::unsetenv("ERTBENCH_DEVICE");
  if (torch::cuda::is_available()) return;
  EXPECT_TRUE(training_device("auto").is_cpu());
  EXPECT_THAT(message_of<InputError>([] { training_device("cuda"); }),
              ::testing::HasSubstr("or train on \"cpu\""));
}

/// libtorch's own Adam is the judge.
TEST(Training, AdamIsLibtorchs) {
  torch::manual_seed(3);
  const auto parameters = [] {
    return std::vector{torch::ones({3, 2}).set_requires_grad(true),
                       torch::ones({4}).set_requires_grad(true), torch::ones({2})};
  };
  std::vector<torch::Tensor> ours = parameters();
  std::vector<torch::Tensor> theirs = parameters();
  Adam adam({{ours[0]}, {ours[1], ours[2]}}, 0.5);
  torch::optim::Adam reference(theirs, torch::optim::AdamOptions(0.01).betas({0.5, 0.999}));
  adam.set_rate(0, 0.01);
  adam.set_rate(1, 0.01);
  for (int step = 0; step < 5; ++step) {
    const torch::Tensor a = torch::randn({3, 2});
    const torch::Tensor b = torch::randn({4});
    const auto loss = [&](const std::vector<torch::Tensor>& x) {
      return (a * x[0] * x[0]).sum() + (b * x[1]).exp().sum();
    };
    adam.zero_grad();
    loss(ours).backward();
    adam.step();
    reference.zero_grad();
    loss(theirs).backward();
    reference.step();
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT((ours[i] - theirs[i]).abs().max().item<double>(), 1e-6) << i;
  }
}

TEST(TrainingSet, ChangesTheWholeSheetAsTold) {
  const TrainingFiles files;
  const DatasetFile& file = *files.input().training;
  const Standardisation standardisation = Standardisation::of(file);
  TrainingSettings settings = small_settings();
  settings.symmetries = false;
  settings.faults.level = {0.1, 0.1};
  settings.faults.snr_db = {200, 200};
  settings.faults.share = 1;
  TrainingSet scenes(file, standardisation, settings);
  scenes.begin_epoch(0);
  const torch::Tensor frames = scenes.batch(0, 8).frames;
  const Frames clean = file.clean_voltages(0, file.size());
  for (std::int64_t i = 0; i < 8; ++i) {
    const torch::Tensor frame = frames[i].contiguous();
    const Eigen::Map<const Eigen::RowVectorXf> x(frame.data_ptr<float>(), clean.cols());
    const Eigen::RowVectorXd change =
        -(x.cwiseQuotient(standardisation.scale) + standardisation.mean).cast<double>();
    const Eigen::RowVectorXd even = 1.1 * (change + file.reference_voltages().transpose());
    // It is one of the file's scenes, at 1.1 times its conductivity.
    EXPECT_LT((clean.rowwise() - even).rowwise().norm().minCoeff(), 1e-4 * even.norm());
  }
}

/// Gradients and displaced electrodes follow their responses, which the exact model shares.
TEST(TrainingSet, DisplacesElectrodesToFirstOrder) {
  const Sensor sensor;
  const Eigen::MatrixXd responses = Nuisances{.electrodes = 1}.responses(sensor);
  const Eigen::VectorXd moved = 0.002 * random_matrix(16, 1, 3);
  const Eigen::VectorXd exact =
      BorderModel(sensor, moved).reference_voltages() - BorderModel(sensor).reference_voltages();
  EXPECT_LT((responses * moved - exact).norm(), 0.1 * exact.norm());
}

class Interrupted : public std::exception {};

/// The checkpoint after two epochs of a training that then died.
void leave_checkpoint(SmallTraining training, const TemporaryFolder& folder) {
  // Showing the third epoch means that two are in the checkpoint; then it dies.
  const auto dies = [&](std::uint64_t, std::uint64_t, const std::string& text) {
    if (text.starts_with("epoch 3")) throw Interrupted();
  };
  TrainingOutlet outlet{.folder = folder / "", .checkpoint_interval_s = 0, .progress = dies};
  outlet.progress_interval_s = 0;
  EXPECT_THROW(training.run(outlet), Interrupted);
  EXPECT_TRUE(fs::exists(folder / "checkpoint.h5"));
}

TEST(Training, GoesOnAfterAnInterruptionAsIfThereHadBeenNone) {
  const TrainingFiles files;
  AdversarialSettings lively;
  lively.spectral_norm = true;
  lively.instance_noise = 0.1;
  lively.label_smoothing = 0.1;
  AdversarialSettings alone;  // no discriminator
  alone.alpha = 0;
  AdversarialSettings lazy;  // 4 is no divisor of an epoch's 6 steps
  lazy.every = 4;
  for (const AdversarialSettings& game : {AdversarialSettings{}, lively, alone, lazy}) {
    SCOPED_TRACE(game.alpha + game.instance_noise);
    TrainingSettings settings = small_settings();
    settings.new_scenes = !game.spectral_norm;
    const std::vector<double> whole = weights_after(files, settings, game);

    const TemporaryFolder folder;
    leave_checkpoint(SmallTraining(files, settings, game), folder);
    SmallTraining resumed(files, settings, game);
    int first_epoch = 0;
    TrainingOutlet outlet{.folder = folder / "", .progress = [&](auto, auto, const auto& text) {
                            if (first_epoch == 0) first_epoch = std::stoi(text.substr(6));
                          }};
    outlet.progress_interval_s = 0;
    const TrainingResult result = resumed.run(outlet);
    EXPECT_EQ(first_epoch, 3);
    EXPECT_EQ(result.epochs, 4);
    EXPECT_EQ(resumed.weights(), whole);
    EXPECT_FALSE(fs::exists(folder / "checkpoint.h5"));
    std::ifstream log(folder / "training.csv");
    int lines = 0;
    for (std::string line; std::getline(log, line);) ++lines;
    EXPECT_EQ(lines, 5);
  }
}

/// Holds that a training in the folder takes no notice of the checkpoint there.
void expect_begins_anew(const TrainingFiles& files, const TemporaryFolder& folder) {
  SmallTraining training(files, small_settings());
  const TrainingResult result = training.run({.folder = folder / ""});
  EXPECT_EQ(result.epochs, 4);
  EXPECT_EQ(result.report.earlier_s, 0);
  EXPECT_EQ(training.weights(), weights_after(files, small_settings()));
  EXPECT_FALSE(fs::exists(folder / "checkpoint.h5"));
}

TEST(Training, ADamagedCheckpointIsNotUsed) {
  const TrainingFiles files;
  const TemporaryFolder folder;
  std::ofstream(folder / "checkpoint.h5") << "torn";
  expect_begins_anew(files, folder);
  leave_checkpoint(SmallTraining(files, small_settings()), folder);
  fs::resize_file(folder / "checkpoint.h5", fs::file_size(folder / "checkpoint.h5") / 2);
  expect_begins_anew(files, folder);
  leave_checkpoint(SmallTraining(files, small_settings()), folder);
  {
    Hdf5File file = Hdf5File::open_writable(folder / "checkpoint.h5");
    // The last that is read: what was whole before it must not have been taken over by then.
    file.write_rows("/objective/optimiser.0.mean", 0,
                    RowMajorMatrix::Constant(4, 16, std::nan("")));
    file.close();
  }
  expect_begins_anew(files, folder);
}

TEST(Training, ACheckpointOfAnotherNetworkIsNotUsed) {
  const TrainingFiles files;
  const TemporaryFolder folder;
  AdversarialSettings other;
  other.spectral_norm = true;
  leave_checkpoint(SmallTraining(files, small_settings(), other), folder);
  expect_begins_anew(files, folder);
  other.alpha = 0;
  leave_checkpoint(SmallTraining(files, small_settings(), other), folder);
  expect_begins_anew(files, folder);
}

TEST(Training, ACheckpointIsNotCodeThatRuns) {
  const TrainingFiles files;
  const TemporaryFolder folder;
  write_prepared_archive(folder / "checkpoint.h5", folder / "marker");
  expect_begins_anew(files, folder);
  EXPECT_FALSE(fs::exists(folder / "marker"));
}

TEST(Training, ACheckpointThatFindsNoRoomOnTheDiskIsAnErrorOfTheInput) {
  const TrainingFiles files;
  const TemporaryFolder folder;
  SmallTraining training(files, small_settings());
  const std::string message = message_of<InputError>([&] {
    const FileSizeLimit full(20000);
    training.run({.folder = folder / "", .checkpoint_interval_s = 0});
  });
  EXPECT_THAT(message, ::testing::HasSubstr("cannot be written; is the disk full?"));
  EXPECT_FALSE(fs::exists(folder / "checkpoint.h5"));
  EXPECT_FALSE(fs::exists(folder / "checkpoint.h5.part"));
}

TEST(Training, LearnsInEitherPrecision) {
  const TrainingFiles files(256, 40);
  for (const bool bfloat16 : {false, true}) {
    TrainingSettings settings = small_settings();
    settings.epochs = 6;
    settings.bfloat16 = bfloat16;
    const TemporaryFolder folder;
    SmallTraining training(files, settings);
    const double before = training.validation->score(*training.network).error;
    const TrainingResult result = training.run({.folder = folder / ""});
    EXPECT_EQ(result.report.status, "ok");
    EXPECT_LT(result.validation_error, before);
    EXPECT_LT(result.validation_error, 1);  // better than no image
  }
}

TEST(Training, KeepsTheBestWeightsAndStopsEarly) {
  const TrainingFiles files;
  TrainingSettings settings = small_settings();
  settings.epochs = 30;
  settings.one_cycle = false;
  settings.learning_rate = 0.05;  // too much: it soon gets worse
  settings.patience = 2;
  const TemporaryFolder folder;
  SmallTraining training(files, settings);
  const TrainingResult result = training.run({.folder = folder / ""});
  EXPECT_LT(result.epochs, 30);
  EXPECT_EQ(result.epochs - result.best_epoch, 2);
  EXPECT_TRUE(result.converged);
  EXPECT_FALSE(to_json(result).contains("converged"));
  EXPECT_NEAR(training.validation->score(*training.network).error, result.validation_error, 1e-9);
}

TEST(Training, SaysSoWhereItsBestEpochIsTheLastThatItWasAllowed) {
  const TrainingFiles files;
  TrainingSettings settings = small_settings();
  settings.epochs = 1;
  const TemporaryFolder folder;
  const TrainingResult result = SmallTraining(files, settings).run({.folder = folder / ""});
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(to_json(result).at("converged"), false);
  EXPECT_FALSE(training_result_from_json(to_json(result)).converged);
}

TEST(Training, DivergenceIsReported) {
  const TrainingFiles files;
  TrainingSettings settings = small_settings();
  settings.learning_rate = 1e38;
  const TemporaryFolder folder;
  SmallTraining training(files, settings);
  EXPECT_THAT(message_of<std::runtime_error>([&] { training.run({.folder = folder / ""}); }),
              ::testing::HasSubstr("diverged"));
}

TEST(Training, AGeneratorThatIgnoresItsFrameIsReported) {
  const TrainingFiles files;
  TrainingSettings settings = small_settings();
  settings.epochs = 1;
  SmallTraining training(files, settings);
  const torch::NoGradGuard no_gradients;
  // A last bias far below zero: every image is blank.
  for (auto& named : training.network->named_parameters()) {
    if (named.key() == "image.bias") named.value().fill_(-40);
  }
  const TemporaryFolder folder;
  torch::AutoGradMode gradients(true);
  EXPECT_EQ(training.run({.folder = folder / ""}).report.status, "generator collapsed");
}

TEST(TrainingSet, BatchesDependOnSeedEpochAndPlaceAlone) {
  const TrainingFiles files;
  const FitInput input = files.input();
  const Standardisation standardisation = Standardisation::of(*input.training);
  TrainingSet a(*input.training, standardisation, small_settings());
  TrainingSet b(*input.training, standardisation, small_settings());
  a.begin_epoch(0);
  a.batch(0, 16);
  a.begin_epoch(3);
  b.begin_epoch(3);
  EXPECT_TRUE(a.batch(16, 16).frames.equal(b.batch(16, 16).frames));
  const TrainingBatch before = a.batch(0, 16);
  a.begin_epoch(4);
  EXPECT_FALSE(a.batch(0, 16).frames.equal(before.frames));
}

TEST(TrainingSet, AShareOfTheFramesHasFaults) {
  const TrainingFiles files;
  const FitInput input = files.input();
  const Standardisation standardisation = Standardisation::of(*input.training);
  TrainingSettings settings = small_settings();
  TrainingSet faultless(*input.training, standardisation, settings);
  settings.faults.dead_electrodes = {1, 4};
  settings.faults.share = 0.5;
  TrainingSet faulty(*input.training, standardisation, settings);
  TrainingSet again(*input.training, standardisation, settings);
  int different = 0;
  for (std::uint64_t epoch = 0; epoch < 4; ++epoch) {
    faultless.begin_epoch(epoch);
    faulty.begin_epoch(epoch);
    const TrainingBatch good = faultless.batch(0, 96);
    const TrainingBatch bad = faulty.batch(0, 96);
    EXPECT_TRUE(bad.truths.equal(good.truths));
    different += (bad.frames != good.frames).any(1).sum().item<int>();
  }
  EXPECT_NEAR(different / 384.0, 0.5, 0.1);  // four standard deviations of the share
  again.begin_epoch(3);
  EXPECT_TRUE(again.batch(32, 16).frames.equal(faulty.batch(32, 16).frames));
}

TEST(TrainingSet, TurnedScenesAreWhatTheForwardModelSays) {
  const TrainingFiles files(8, 4);
  const FitInput input = files.input();
  Standardisation plain = Standardisation::of(*input.training);
  plain.mean.setZero();
  plain.scale.setOnes();
  const ForwardModel model(input.sensor, input.sensor.image_grid);
  TrainingSet scenes(*input.training, plain, small_settings());
  for (std::uint64_t epoch = 0; epoch < 4; ++epoch) {
    scenes.begin_epoch(epoch);
    const TrainingBatch batch = scenes.batch(0, 8);
    for (int i = 0; i < 8; ++i) {
      const torch::Tensor y = batch.truths[i].flatten().to(torch::kFloat64).contiguous();
      const Eigen::RowVectorXd conductivity =
          input.sensor.background *
          (1 - Eigen::Map<const Eigen::RowVectorXd>(y.data_ptr<double>(), 576).array());
      const Eigen::RowVectorXd expected = model.solve(conductivity).row(0);
      const torch::Tensor drops = batch.frames[i].to(torch::kFloat64).contiguous();
      const Eigen::RowVectorXd seen =
          model.reference_voltages().transpose() -
          Eigen::Map<const Eigen::RowVectorXd>(drops.data_ptr<double>(), 208);
      // The noise is 50 dB below the frame, exactly; float32 adds 1e-7.
      EXPECT_NEAR((seen - expected).norm(), expected.norm() * std::pow(10, -2.5),
                  1e-3 * expected.norm() * std::pow(10, -2.5));
    }
  }
}

}  // namespace
}  // namespace ertbench
