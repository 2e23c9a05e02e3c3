#include "solvers/parameter_choice.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/errors.h"
#include "forward/data/generate.h"
#include "solvers/solver_file.h"
#include "tests/solvers/solver_testing.h"
#include "tests/under_sanitizers.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

double parabola(double value, double best) { return 0.3 + std::pow(std::log10(value / best), 2); }

TEST(ChooseNumber, FindsTheLeastErrorWithinFivePercent) {
  for (const double best : {1.3e-4, 0.021, 0.5}) {
    const ParameterChoice choice =
        choose_number("/x", 1e-4, 1, 3, 7, [&](double v) { return parabola(v, best); });
    EXPECT_NEAR(std::log(choice.value / best), 0, 0.05);
    EXPECT_EQ(choice.error, parabola(choice.value, best));
    EXPECT_EQ(choice.frames, 7);
    EXPECT_TRUE(std::is_sorted(choice.curve.begin(), choice.curve.end()));
    for (const auto& [value, error] : choice.curve) {
      EXPECT_EQ(error, parabola(value, best));
      EXPECT_GE(error, choice.error);
    }
  }
}

TEST(ChooseNumber, ExtendsTheLadderTowardsTheBest) {
  for (const double best : {3e-6, 40.0}) {
    const ParameterChoice choice =
        choose_number("/x", 1e-4, 1, 3, 1, [&](double v) { return parabola(v, best); });
    EXPECT_NEAR(std::log(choice.value / best), 0, 0.05);
  }
}

TEST(ChooseNumber, StopsSomewhereWhereThereIsNoBest) {
  int calls = 0;
  const ParameterChoice choice = choose_number("/x", 1e-4, 1, 3, 1, [&](double v) {
    ++calls;
    return 1 / v;
  });
  EXPECT_GT(choice.value, 99);
  EXPECT_LT(calls, 60);
}

TEST(MeanRelativeError, IsTheMeanOverFrames) {
  Images truths(3, 2);
  truths << 3, 4, 1, 0, 0, 2;
  Images images(3, 2);
  images << 3, 4, 1, 0.5, 77, 77;
  std::vector<FrameReport> reports(3);
  reports[1].status = FrameStatus::not_converged;  // counts with its image
  reports[2].status = FrameStatus::undefined;      // counts as 1 whatever its image
  EXPECT_DOUBLE_EQ(mean_relative_error(images, reports, truths), (0 + 0.5 + 1) / 3);
}

/// A validation set of which every other scene is blank.
class OnAValidationSet : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryFolder>();
    generate_dataset(random_contacts(30, {}, 0.5), *folder_ / "validation.h5");
    generate_dataset(random_contacts(4, {}, 1.0), *folder_ / "blank.h5");
  }
  static void TearDownTestSuite() { folder_.reset(); }

  void SetUp() override { input_.validation = &set_; }

  std::unique_ptr<Solver> fit(const json& spec, int threads = 1) {
    std::unique_ptr<Solver> solver = make_solver(spec);
    input_.threads = threads;
    solver->fit(input_);
    return solver;
  }

  static std::unique_ptr<TemporaryFolder> folder_;
  DatasetFile set_{*folder_ / "validation.h5"};
  FitInput input_;
};

std::unique_ptr<TemporaryFolder> OnAValidationSet::folder_;

TEST_F(OnAValidationSet, BlankFramesAreLeftOut) {
  const ValidationFrames frames = read_validation_frames(input_, "/lambda");
  const Images truths = set_.conductivity(0, 30).array() - 0.06;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < 30; ++f) {
    if (truths.row(f).norm() < 1e-10) continue;
    EXPECT_EQ(frames.truths.row(kept), truths.row(f));
    EXPECT_EQ(frames.changes.row(kept), set_.voltages(static_cast<std::uint64_t>(f), 1).row(0) -
                                            set_.reference_voltages().transpose());
    ++kept;
  }
  EXPECT_EQ(frames.truths.rows(), kept);
  EXPECT_GT(kept, 5);
  EXPECT_LT(kept, 25);
}

TEST_F(OnAValidationSet, EverySolverChoosesTheBestOfWhatItTried) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  const ValidationFrames frames = read_validation_frames(input_, "");
  for (const auto& [type, key, neighbour] : {std::tuple{"one-step-gn", "lambda", 1.3},
                                             {"tsvd", "rank", 0.0},
                                             {"tsvd", "threshold", 1.6},
                                             {"pdipm", "alpha", 1.5}}) {
    SCOPED_TRACE(std::string(type) + " " + key);
    const std::unique_ptr<Solver> solver = fit({{"type", type}, {key, "auto"}});
    const json parameters = solver->parameters();
    const json& chosen = parameters["chosen"];
    const double value = parameters[key];
    const double error = chosen["error"];
    EXPECT_EQ(chosen["value"], value);
    EXPECT_EQ(chosen["frames"], frames.truths.rows());
    EXPECT_DOUBLE_EQ(mean_relative_error(*solver, frames, 1), error);
    // Better than doing nothing, and than its neighbours.
    EXPECT_LT(error, 1);
    const auto error_of = [&](json other) {
      return mean_relative_error(*fitted({{"type", type}, {key, other}}), frames, 1);
    };
    if (neighbour == 0) {
      EXPECT_LE(error, error_of(parameters[key].get<int>() - 3));
      EXPECT_LE(error, error_of(parameters[key].get<int>() + 3));
    } else {
      EXPECT_LE(error, error_of(value / neighbour));
      EXPECT_LE(error, error_of(value * neighbour));
    }
  }
}

TEST_F(OnAValidationSet, RankAndThresholdAreChosenAlike) {
  const std::unique_ptr<Solver> by_rank = fit({{"type", "tsvd"}, {"rank", "auto"}});
  const std::unique_ptr<Solver> by_threshold = fit({{"type", "tsvd"}, {"threshold", "auto"}});
  const Frames changes = eidors_changes();
  EXPECT_EQ(reconstruct(*by_rank, changes).images, reconstruct(*by_threshold, changes).images);
  // What was chosen gives the same when it is asked for by number.
  json spec = {{"type", "tsvd"}, {"threshold", by_threshold->parameters()["threshold"]}};
  EXPECT_LT(relative_difference(reconstruct(*fitted(spec), changes).images,
                                reconstruct(*by_rank, changes).images),
            1e-9);
}

TEST_F(OnAValidationSet, RanksTriedKeepPairsWhole) {
  // Values 2 and 3 of the square sensor are equal, and so are 6 and 7.
  const json curve = fit({{"type", "tsvd"}})->parameters()["chosen"]["curve"];
  EXPECT_GT(curve.size(), 50u);
  for (const json& entry : curve) {
    EXPECT_NE(entry[0], 2);
    EXPECT_NE(entry[0], 6);
  }
}

TEST_F(OnAValidationSet, TheChoiceDoesNotDependOnTheNumberOfThreads) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  for (const char* type : {"one-step-gn", "tsvd", "pdipm"}) {
    EXPECT_EQ(fit({{"type", type}}, 1)->parameters(), fit({{"type", type}}, 3)->parameters());
  }
}

TEST_F(OnAValidationSet, TheChoiceIsKept) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  const TemporaryFolder folder;
  for (const char* type : {"one-step-gn", "tsvd", "pdipm"}) {
    const std::unique_ptr<Solver> solver = fit({{"type", type}});
    solver->save(folder / "solver.h5");
    const std::unique_ptr<Solver> loaded = make_solver({{"type", type}});
    loaded->load(folder / "solver.h5", Sensor{});
    EXPECT_EQ(loaded->parameters(), solver->parameters());
    // Reported parameters can be given back, and refitting leaves them.
    json spec = solver->parameters();
    spec["type"] = type;
    const std::unique_ptr<Solver> again = fit(spec);
    EXPECT_EQ(again->parameters(), solver->parameters());
    // A record of a choice does not outlive the value it is of.
    spec[std::string(type) == "tsvd"    ? "rank"
         : std::string(type) == "pdipm" ? "alpha"
                                        : "lambda"] = 5;
    EXPECT_FALSE(make_solver(spec)->parameters().contains("chosen"));
  }
}

TEST(StoredFit, HasANumberWhereOneWasToBeChosen) {
  const TemporaryFolder folder;
  for (const auto& [type, key] :
       {std::pair("one-step-gn", "lambda"), std::pair("tsvd", "rank"), std::pair("pdipm", "alpha"),
        std::pair("lmmse", "ridge"), std::pair("gauss-newton", "lambda")}) {
    const std::filesystem::path file = folder / (std::string(type) + ".h5");
    create_solver_file(file, type, {}, {{key, "auto"}});
    const std::unique_ptr<Solver> solver = make_solver({{"type", type}});
    EXPECT_EQ(message_of<InputError>([&] { solver->load(file, Sensor{}); }),
              file.string() + ": /parameters/" + key +
                  ": must be a number in a fit; fit the solver again");
  }
}

TEST_F(OnAValidationSet, RefusesASetItCannotUse) {
  const DatasetFile blank(*folder_ / "blank.h5");
  input_.validation = &blank;
  const std::string none = message_of<InputError>([&] { fit({{"type", "tsvd"}}); });
  EXPECT_EQ(none.find("spec.json: /rank: \"auto\" needs a validation set with contacts"), 0u)
      << none;
  input_.validation = &set_;
  input_.sensor.drive_current = 1;
  const std::string other = message_of<InputError>([&] { fit({{"type", "tsvd"}}); });
  EXPECT_NE(other.find("another sensor"), std::string::npos) << other;
}

}  // namespace
}  // namespace ertbench
