// The reference follows the sheet while nothing presses, and never a press.

#include "solvers/front/quiet_reference.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "forward/border/border_model.h"

namespace ertbench {
namespace {

constexpr double frames_per_s = 20;

/// Frames of the exact model at 50 dB, a twentieth of a second apart.
class QuietReferenceOfFrames : public ::testing::Test {
 protected:
  /// Follows for `seconds` a sheet of this level, pressed by the contacts; the last change.
  Eigen::RowVectorXd stay(double seconds, double level, const Scene& scene = {}) {
    const Eigen::VectorXd reference = model_.reference_voltages();
    const Eigen::VectorXd voltages =
        (reference + model_.solve(scene, 1e-5 * reference.norm()).change) / (1 + level);
    Eigen::RowVectorXd change;
    for (int f = 0; f < seconds * frames_per_s; ++f) {
      change = (voltages - reference).transpose();
      for (double& value : change) value += noise_ * random_.normal();
      follower_.follow(change, now_s_ += 1 / frames_per_s);
    }
    return change;
  }
  static Scene press(double radius, double ratio) {
    Contact contact;
    contact.centre = {0.2, 0.3};
    contact.half_size = {radius, radius};
    contact.conductivity_ratio = ratio;
    return {{contact}};
  }
  /// Root mean square of a channel.
  static double size(const Eigen::RowVectorXd& change) {
    return change.norm() / std::sqrt(static_cast<double>(change.size()));
  }

  BorderModel model_{Sensor{}};
  double noise_ = size(model_.reference_voltages().transpose()) / std::sqrt(1e5);
  RandomStream random_{7, 0, 0, Purpose::noise};
  QuietReference follower_{Sensor{}};
  double now_s_ = 0;
};

TEST_F(QuietReferenceOfFrames, FollowsALevelThatDriftsAndOneThatSteps) {
  for (int minute = 1; minute <= 5; ++minute) {
    // Noise alone scatters by 5 % in 208 channels.
    EXPECT_LT(size(stay(60, -0.001 * minute)), 1.3 * noise_) << minute;
  }
  EXPECT_LT(size(stay(10, 0.05)), 1.3 * noise_);
}

TEST_F(QuietReferenceOfFrames, DoesNotLearnAConstantPressInTenMinutes) {
  stay(10, 0);
  const Eigen::RowVectorXd before = follower_.drift();
  for (const auto& [radius, ratio] : {std::pair{0.3, 0.5}, std::pair{0.15, 0.7}, {0.1, 0.8}}) {
    const Eigen::RowVectorXd change = model_.solve(press(radius, ratio), 1e-7).change.transpose();
    stay(600, 0, press(radius, ratio));
    // Beside the noise of the seconds' means along three responses, sqrt(2 * 3 / 20) of a
    // channel's.
    EXPECT_LT((follower_.drift() - before).norm(), 0.02 * change.norm() + 1.5 * noise_) << radius;
    EXPECT_GT(change.norm(), 5 * noise_);
    stay(10, 0);
    EXPECT_LT(size(follower_.drift()), 0.3 * noise_);
  }
}

TEST_F(QuietReferenceOfFrames, CatchesUpAfterAPressOnASheetThatDrifted) {
  stay(10, 0);
  const Eigen::RowVectorXd pressed = stay(120, -0.02, press(0.25, 0.5));
  EXPECT_GT(size(pressed), 5 * noise_);
  EXPECT_LT(size(stay(10, -0.02)), 1.3 * noise_);
}

}  // namespace
}  // namespace ertbench
