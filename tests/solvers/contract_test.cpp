// What every solver promises (solvers/solver.h), for each of the classical ones.

#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "forward/errors.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

class SolverContract : public ::testing::TestWithParam<json> {
 protected:
  /// Twelve frames: blank, noise alone, contacts, a large one.
  static Frames frames() {
    Frames changes = random_changes(12);
    changes.row(0).setZero();
    changes.row(1) = 1e-3 * (changes.row(2) - changes.row(3));
    changes.row(5) *= 100;
    return changes;
  }
  static bool linear() { return GetParam()["type"] != "pdipm"; }

  std::unique_ptr<Solver> solver_ = fitted(GetParam());
};

TEST_P(SolverContract, ABatchIsTheSameAsItsFrames) {
  const Frames changes = frames();
  const Reconstruction batch = reconstruct(*solver_, changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const Reconstruction single = reconstruct(*solver_, changes.row(f));
    EXPECT_EQ(single.reports[0].status, batch.reports[static_cast<std::size_t>(f)].status);
    if (linear()) {
      // Sums of 104 products, in another order.
      EXPECT_LE((single.images - batch.images.row(f)).norm(), 1e-13 * single.images.norm());
    } else {
      EXPECT_EQ(single.images.row(0), batch.images.row(f));
    }
  }
}

TEST_P(SolverContract, TwoThreadsMayShareASolver) {
  const Frames changes = frames();
  const Reconstruction alone = reconstruct(*solver_, changes);
  Reconstruction first;
  Reconstruction second;
  std::thread a([&] { first = reconstruct(*solver_, changes); });
  std::thread b([&] { second = reconstruct(*solver_, changes); });
  a.join();
  b.join();
  EXPECT_EQ(first.images, alone.images);
  EXPECT_EQ(second.images, alone.images);
}

TEST_P(SolverContract, ReadsFramesAndWritesImagesInsideLargerArrays) {
  const Frames changes = frames();
  Frames wide = Frames::Constant(changes.rows(), changes.cols() + 5, 7.0);
  wide.middleCols(2, changes.cols()) = changes;
  const Sensor sensor;
  Images around = Images::Constant(changes.rows(), sensor.pixels() + 4, -3.0);
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  solver_->reconstruct(wide.middleCols(2, changes.cols()), around.middleCols(1, sensor.pixels()),
                       reports);
  EXPECT_EQ(Images(around.middleCols(1, sensor.pixels())), reconstruct(*solver_, changes).images);
  EXPECT_TRUE((around.leftCols(1).array() == -3).all());
  EXPECT_TRUE((around.rightCols(3).array() == -3).all());
}

TEST_P(SolverContract, ASavedSolverIsTheSameAgain) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  json other = GetParam();
  other.erase("rank");
  other.erase("lambda");
  other.erase("alpha");
  other.erase("prior");
  const std::unique_ptr<Solver> loaded = make_solver(other);
  loaded->load(folder / "solver.h5", Sensor{});
  EXPECT_EQ(loaded->parameters(), solver_->parameters());
  const Frames changes = frames();
  EXPECT_EQ(reconstruct(*loaded, changes).images, reconstruct(*solver_, changes).images);
}

TEST_P(SolverContract, RefusesTheFileOfAnotherSensor) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  Sensor other;
  other.background = 0.05;
  const std::string message =
      message_of<InputError>([&] { make_solver(GetParam())->load(folder / "solver.h5", other); });
  EXPECT_NE(message.find("solver.h5"), std::string::npos) << message;
  EXPECT_NE(message.find("sensor"), std::string::npos) << message;
}

TEST_P(SolverContract, RefusesTheFileOfAnotherSolver) {
  const TemporaryFolder folder;
  solver_->save(folder / "solver.h5");
  const json other = linear() && GetParam()["type"] != "one-step-gn"
                         ? json{{"type", "one-step-gn"}, {"lambda", 1}}
                         : json{{"type", "tsvd"}, {"rank", 3}};
  const std::string message =
      message_of<InputError>([&] { make_solver(other)->load(folder / "solver.h5", Sensor{}); });
  EXPECT_NE(message.find(GetParam()["type"].get<std::string>()), std::string::npos) << message;
}

TEST_P(SolverContract, RefusesAFileThatIsNoSolver) {
  EXPECT_THROW(make_solver(GetParam())->load(ERTBENCH_TEST_DATA "/eidors_d2s.h5", Sensor{}),
               InputError);
  EXPECT_THROW(make_solver(GetParam())->load("/nowhere/solver.h5", Sensor{}), InputError);
}

TEST_P(SolverContract, ItsParametersMakeItAgain) {
  json spec = solver_->parameters();
  spec["type"] = GetParam()["type"];
  const std::unique_ptr<Solver> again = fitted(spec);
  EXPECT_EQ(again->parameters(), solver_->parameters());
  const Frames changes = frames();
  EXPECT_EQ(reconstruct(*again, changes).images, reconstruct(*solver_, changes).images);
}

TEST_P(SolverContract, AZeroFrameGivesAZeroImage) {
  const Reconstruction blank = reconstruct(*solver_, Frames::Zero(1, Sensor{}.channels()));
  EXPECT_TRUE((blank.images.array() == 0).all());
  EXPECT_EQ(blank.reports[0].status, FrameStatus::ok);
}

TEST_P(SolverContract, AFrameThatIsNotFiniteIsUndefinedAndAloneInThat) {
  Frames changes = frames();
  const Reconstruction before = reconstruct(*solver_, changes);
  changes(3, 17) = std::numeric_limits<double>::quiet_NaN();
  changes(7, 0) = std::numeric_limits<double>::infinity();
  const Reconstruction after = reconstruct(*solver_, changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const bool broken = f == 3 || f == 7;
    const FrameReport& report = after.reports[static_cast<std::size_t>(f)];
    EXPECT_EQ(report.status == FrameStatus::undefined, broken) << f;
    if (!broken) {
      EXPECT_EQ(after.images.row(f), before.images.row(f)) << f;
    }
  }
  EXPECT_EQ(reconstruct(*solver_, changes.row(3)).reports[0].status, FrameStatus::undefined);
}

TEST_P(SolverContract, SeesAContactWhereItIs) {
  // The scenes of EIDORS's with weak contacts (0.6 of the background), which J describes.
  const Images truths = eidors().read_rows("/scenes/conductivity", 0, 3).array() - 0.06;
  const Images images = reconstruct(*solver_, eidors_changes().topRows(3)).images;
  for (Eigen::Index f = 0; f < truths.rows(); ++f) {
    const double cosine =
        images.row(f).dot(truths.row(f)) / images.row(f).norm() / truths.row(f).norm();
    EXPECT_GT(cosine, 0.5) << f;  // about 0 for an image that has nothing to do with the truth
  }
}

TEST_P(SolverContract, RefusesUseBeforeItIsFitted) {
  const std::unique_ptr<Solver> raw = make_solver(GetParam());
  const TemporaryFolder folder;
  EXPECT_THROW(reconstruct(*raw, frames()), std::logic_error);
  EXPECT_THROW(raw->save(folder / "solver.h5"), std::logic_error);
}

TEST_P(SolverContract, RefusesAnUnknownParameter) {
  json spec = GetParam();
  spec["lamda"] = 1;
  const std::string message = message_of<InputError>([&] { make_solver(spec); });
  EXPECT_EQ(message.find("spec.json: /lamda: unknown key"), 0u) << message;
}

INSTANTIATE_TEST_SUITE_P(
    Classical, SolverContract,
    ::testing::Values(json{{"type", "one-step-gn"}, {"prior", "tikhonov"}, {"lambda", 0.02}},
                      json{{"type", "one-step-gn"}, {"prior", "noser"}, {"lambda", 0.1}},
                      json{{"type", "one-step-gn"}, {"prior", "laplace"}, {"lambda", 0.02}},
                      json{{"type", "tsvd"}, {"rank", 45}},
                      json{{"type", "tsvd"}, {"threshold", 0.02}},
                      json{{"type", "pdipm"}, {"alpha", 1e-5}}),
    [](const auto& instance) {
      std::string name;
      for (const char* key : {"type", "prior", "threshold"}) {
        if (instance.param.contains(key)) {
          name += instance.param[key].is_string() ? instance.param[key].template get<std::string>()
                                                  : std::string(key);
        }
      }
      std::erase(name, '-');
      return name;
    });

}  // namespace
}  // namespace ertbench
