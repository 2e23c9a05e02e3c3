#include "solvers/total_variation/pdipm.h"

#include <gtest/gtest.h>

#include "core/errors.h"
#include "forward/fem/forward_model.h"
#include "solvers/solver_file.h"
#include "tests/solvers/solver_testing.h"
#include "tests/solvers/total_variation_reference.h"
#include "tests/under_sanitizers.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

json spec(double alpha, double tolerance = 1e-4, int max_iterations = 50) {
  return {{"type", "pdipm"},
          {"alpha", alpha},
          {"tolerance", tolerance},
          {"max_iterations", max_iterations}};
}

Sensor coarse() {
  Sensor sensor;
  sensor.image_grid = 8;
  return sensor;
}

TEST(Pdipm, ReachesTheMinimumThatASlowMethodFinds) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  const Sensor sensor = coarse();
  const Frames changes = random_changes(3, sensor);
  for (const double alpha : {1e-7, 1e-6, 1e-5, 1e-4}) {
    const DenseTotalVariation reference(sensor, alpha);
    const Reconstruction out = reconstruct(*fitted(spec(alpha), sensor), changes, sensor);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const Eigen::VectorXd d = changes.row(f);
      const double slow = reference.objective(reference.admm(d, 20000), d);
      const double ours = reference.objective(out.images.row(f), d);
      const FrameReport& report = out.reports[static_cast<std::size_t>(f)];
      EXPECT_EQ(report.status, FrameStatus::ok);
      EXPECT_LE(ours, slow * (1 + 1e-4)) << "alpha " << alpha << ", frame " << f;
      // No image is below the bound, the slow method's neither; and it got close to it, so that
      // the bound is known not to be a loose one.
      EXPECT_GE(slow, ours * (1 - report.gap) * (1 - 1e-12)) << "alpha " << alpha;
      EXPECT_LE(slow, ours * (1 + 1e-3)) << "alpha " << alpha;
    }
  }
}

TEST(Pdipm, ReachesTheMinimumOnTheWholeSensor) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  const Frames changes = random_changes(1);
  const DenseTotalVariation reference(Sensor{}, 1e-5);
  const Eigen::VectorXd d = changes.row(0);
  const Reconstruction out = reconstruct(*fitted(spec(1e-5, 1e-6)), changes);
  const double ours = reference.objective(out.images.row(0), d);
  const double slow = reference.objective(reference.admm(d, 3000), d);
  EXPECT_EQ(out.reports[0].status, FrameStatus::ok);
  EXPECT_LE(ours, slow * (1 + 1e-6));
  EXPECT_LE(slow, ours * (1 + 1e-2));
}

TEST(Pdipm, IsNotAboveThePublishedIteration) {
  ERTBENCH_NOT_UNDER_SANITIZERS();
  const Frames changes = random_changes(1);
  for (const double alpha : {1e-6, 1e-5}) {
    const DenseTotalVariation reference(Sensor{}, alpha);
    const Reconstruction out = reconstruct(*fitted(spec(alpha)), changes);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const Eigen::VectorXd d = changes.row(f);
      EXPECT_LE(reference.objective(out.images.row(f), d),
                reference.objective(reference.borsic(d, 20), d) * (1 + 1e-4));
    }
  }
}

TEST(Pdipm, ItsGapIsATrueBound) {
  const Frames changes = random_changes(6);
  for (const double alpha : {1e-7, 1e-5, 1e-3}) {
    const DenseTotalVariation reference(Sensor{}, alpha);
    const Reconstruction tight = reconstruct(*fitted(spec(alpha, 1e-7)), changes);
    for (const double tolerance : {1e-1, 1e-2, 1e-3}) {
      const Reconstruction loose = reconstruct(*fitted(spec(alpha, tolerance)), changes);
      for (Eigen::Index f = 0; f < changes.rows(); ++f) {
        const Eigen::VectorXd d = changes.row(f);
        const double gap = loose.reports[static_cast<std::size_t>(f)].gap;
        const double above = reference.objective(loose.images.row(f), d);
        const double least = reference.objective(tight.images.row(f), d);
        EXPECT_LE(gap, tolerance);
        EXPECT_LE(above * (1 - gap), least * (1 + 1e-12)) << alpha << " " << tolerance;
      }
    }
  }
}

TEST(Pdipm, ConvergesWhateverTheWeight) {
  // Small alphas fit the noise, large ones give the constant image; in between lies what is used.
  Frames changes = random_changes(10);
  changes.row(0) = changes.row(1) * 1e-3;                    // fainter than the noise
  changes.row(2) = (changes.row(3) - changes.row(4)) * 0.1;  // not of one sheet
  for (int exponent = -9; exponent <= 3; ++exponent) {
    const double alpha = std::pow(10.0, exponent);
    const Reconstruction out = reconstruct(*fitted(spec(alpha)), changes);
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const FrameReport& report = out.reports[static_cast<std::size_t>(f)];
      EXPECT_EQ(report.status, FrameStatus::ok) << "alpha " << alpha << ", frame " << f;
      EXPECT_LE(report.gap, 1e-4);
      EXPECT_LE(report.iterations, 25) << "alpha " << alpha << ", frame " << f;
      EXPECT_TRUE(out.images.row(f).allFinite());
    }
  }
}

TEST(Pdipm, ConvergesTightly) {
  // 1e-8 is within reach of rounding only because J x = w is refined in the Newton system.
  const Frames changes = random_changes(10);
  for (int exponent = -8; exponent <= -3; ++exponent) {
    const Reconstruction out = reconstruct(*fitted(spec(std::pow(10.0, exponent), 1e-8)), changes);
    for (const FrameReport& report : out.reports) {
      EXPECT_EQ(report.status, FrameStatus::ok) << "alpha 1e" << exponent << " " << report.gap;
    }
  }
}

TEST(Pdipm, ConvergesOnOtherSensors) {
  Sensor fine;
  fine.image_grid = 48;
  Sensor few;
  few.electrode_count = 8;
  few.electrode_offset = 0.5;
  for (const Sensor& sensor : {coarse(), fine, few}) {
    const Frames changes = random_changes(3, sensor);
    for (const double alpha : {1e-8, 1e-5, 1e-2}) {
      const Reconstruction out = reconstruct(*fitted(spec(alpha), sensor), changes, sensor);
      for (const FrameReport& report : out.reports) {
        EXPECT_EQ(report.status, FrameStatus::ok)
            << sensor.image_grid << " " << sensor.electrode_count << " alpha " << alpha;
        EXPECT_LE(report.iterations, 25);
      }
    }
  }
}

TEST(Pdipm, IsNeverNotANumber) {
  // Extremes that no sensor sends: a status, and a finite image.
  Frames changes(8, 208);
  changes.setZero();
  changes(1, 0) = 1e-320;
  changes(2, 0) = 1e-200;
  changes.row(3) = random_changes(1) * 1e9;
  changes.row(4) = random_changes(1) * 1e150;
  changes.row(5).setConstant(1.7e308);
  changes(6, 5) = 1;
  changes.row(7) = ForwardModel(Sensor{}, 24).reference_voltages().transpose();  // exactly constant
  for (const double alpha : {1e-20, 1e-14, 1e-5, 1.0, 1e20}) {  // the range's ends among them
    const Reconstruction out = reconstruct(*fitted(spec(alpha)), changes);
    EXPECT_TRUE(out.images.allFinite()) << alpha;
    for (const FrameReport& report : out.reports) {
      EXPECT_TRUE(std::isfinite(report.gap));
      EXPECT_EQ(report.status == FrameStatus::ok,
                report.gap <= 1e-4 && report.status != FrameStatus::undefined);
    }
  }
}

TEST(Pdipm, ReportsWhatHasNotConverged) {
  const Frames changes = random_changes(2);
  const Reconstruction out = reconstruct(*fitted(spec(1e-6, 1e-8, 3)), changes);
  for (const FrameReport& report : out.reports) {
    EXPECT_EQ(report.status, FrameStatus::not_converged);
    EXPECT_EQ(report.iterations, 3);
    EXPECT_GT(report.gap, 1e-8);
    EXPECT_LE(report.gap, 1);
  }
}

TEST(Pdipm, ALargeWeightLeavesTheBestConstant) {
  // (J 1)^T d / |J 1|^2.
  const Frames changes = eidors_changes();
  const Eigen::VectorXd constant = ForwardModel(Sensor{}, 24).jacobian().rowwise().sum();
  const Reconstruction out = reconstruct(*fitted(spec(10)), changes);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const double best = changes.row(f).dot(constant) / constant.squaredNorm();
    EXPECT_LT((out.images.row(f).array() - best).abs().maxCoeff(), 1e-10 * std::abs(best));
    EXPECT_EQ(out.reports[static_cast<std::size_t>(f)].iterations, 0);
  }
}

TEST(Pdipm, ScalesWithTheSensor) {
  // A current k times as strong scales d and J alike: the same image for alpha k^2. A background
  // k times as conductive scales d by 1/k, J by 1/k^2: k times the image for alpha / k^3.
  const double k = 7;
  Sensor sensor;
  const Frames changes = random_changes(4);
  const Images images = reconstruct(*fitted(spec(1e-5)), changes).images;

  Sensor strong;
  strong.drive_current = k * sensor.drive_current;
  const Images by_current =
      reconstruct(*fitted(spec(1e-5 * k * k), strong), k * changes, strong).images;
  EXPECT_LT(relative_difference(by_current, images), 1e-8);

  Sensor conductive;
  conductive.background = k * sensor.background;
  const Images by_background =
      reconstruct(*fitted(spec(1e-5 / k / k / k), conductive), changes / k, conductive).images;
  EXPECT_LT(relative_difference(by_background, k * images), 1e-8);
}

TEST(Pdipm, FollowsTheSymmetriesOfTheSensor) {
  // The sheet turned by a quarter, clockwise, is the sensor with its electrodes moved on by four.
  const Sensor sensor;
  const std::vector<Channel> channels = channels_of(sensor);
  const Frames changes = random_changes(2);
  Frames turned(changes.rows(), changes.cols());
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const Channel to{(channels[c].drive + 4) % 16, (channels[c].measurement + 4) % 16};
    for (std::size_t k = 0; k < channels.size(); ++k) {
      if (channels[k].drive == to.drive && channels[k].measurement == to.measurement) {
        turned.col(static_cast<Eigen::Index>(k)) = changes.col(static_cast<Eigen::Index>(c));
      }
    }
  }
  const auto solver = fitted(spec(1e-5, 1e-8));
  const Images images = reconstruct(*solver, changes).images;
  const Images of_turned = reconstruct(*solver, turned).images;
  for (Eigen::Index f = 0; f < 2; ++f) {
    const Eigen::Map<const RowMajorMatrix> image(images.row(f).data(), 24, 24);
    const Eigen::Map<const RowMajorMatrix> other(of_turned.row(f).data(), 24, 24);
    // A quarter turn clockwise takes (x, y) to (y, -x): column to row reversed.
    const RowMajorMatrix expected = image.transpose().colwise().reverse();
    EXPECT_LT(relative_difference(other, expected), 1e-4);
  }
}

TEST(Pdipm, LoadsFilesFromBeforeFramesWereJudged) {
  const TemporaryFolder folder;
  create_solver_file(folder / "old.h5", "pdipm", {},
                     {{"alpha", 1e-5}, {"tolerance", 1e-4}, {"max_iterations", 50}});
  const auto solver = make_solver({{"type", "pdipm"}});
  solver->load(folder / "old.h5", {});
  Frames changes = random_changes(2);
  changes.row(1) = -ForwardModel(Sensor{}, 24).reference_voltages().transpose();
  const Reconstruction out = reconstruct(*solver, changes);
  EXPECT_EQ(out.reports[0].status, FrameStatus::ok);
  EXPECT_EQ(out.reports[1].reasons, dead_electrode);
}

TEST(Pdipm, NamesWhatIsWrong) {
  const auto message = [](const json& parameters) {
    json whole = parameters;
    whole["type"] = "pdipm";
    return message_of<InputError>([&] { fitted(whole); });
  };
  EXPECT_EQ(message({{"alpha", 0}}), "spec.json: /alpha: must be > 0 or \"auto\", got 0");
  EXPECT_EQ(message(json::object()),
            "spec.json: /alpha: \"auto\" needs a validation set; give a number");
  EXPECT_EQ(message({{"alpha", 1}, {"tolerance", 0}}).find("spec.json: /tolerance: must be"), 0u);
  EXPECT_EQ(message({{"alpha", 1}, {"max_iterations", 0}}).find("spec.json: /max_iterations: must"),
            0u);
}

}  // namespace
}  // namespace ertbench
