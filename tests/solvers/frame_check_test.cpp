#include "solvers/front/frame_check.h"

#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "forward/fem/forward_model.h"
#include "tests/solvers/fault_frames.h"

namespace ertbench {
namespace {

using namespace testing;

class Check : public ::testing::Test {
 protected:
  static const FrameCheck& check() {
    static const ValidationFile validation;
    static const FrameCheck check(validation.input(), 0);
    return check;
  }
  /// Share of the frames with all of `reasons`, or with any where it is 0.
  static double share(const Frames& changes, int reasons = 0) {
    int found = 0;
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const int of_frame = check().judge(changes.row(f).data()).reasons;
      found += reasons == 0 ? of_frame != 0 : (of_frame & reasons) == reasons;
    }
    return found / static_cast<double>(changes.rows());
  }
  static Frames of_scene(const nlohmann::json& scene, double background_change = 0) {
    const nlohmann::json spec = {
        {"count", 100}, {"seed", 5}, {"snr_db", 50}, {"snr_basis", "absolute"}, {"scenes", scene}};
    const SceneModel model(Sensor{}, GridSheet{24});
    const DatasetSpec dataset = dataset_spec_from_json(JsonObject(spec, "test", ""), {}, "test");
    const Frames voltages =
        generate_block(dataset, model, 0, 100).voltages / (1 + background_change);
    return voltages.rowwise() - model.reference_voltages().transpose();
  }
};

TEST_F(Check, LetsGoodFramesPass) {
  // The limits are meant for 0.5 %; 400 frames of the fit place them to within a factor of two.
  EXPECT_LE(share(fresh_changes(4000)), 0.01);
}

TEST_F(Check, FindsElectrodesThatReadZero) {
  Frames changes = fresh_changes(400);
  RandomStream random(1, 0, 0, Purpose::scene);
  int noisy = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const ElectrodeSet dead = random_electrodes(1 + static_cast<int>(f % 4), random);
    read_zero(changes.row(f), dead);
    const FrameCheck::Verdict verdict = check().judge(changes.row(f).data());
    EXPECT_TRUE(verdict.reasons & dead_electrode);
    EXPECT_EQ(pairs_without({}, verdict.dead), pairs_without({}, dead));
    EXPECT_LE(size_of(verdict.dead), size_of(dead));
    noisy += (verdict.reasons & noise) != 0;
  }
  // Noise is judged beside the voltages, of which the dead channels may hide the large ones.
  EXPECT_LE(noisy, 4);
}

TEST_F(Check, FindsElectrodesThatFloat) {
  Frames changes = fresh_changes(400);
  RandomStream random(2, 0, 0, Purpose::scene);
  int found = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const ElectrodeSet dead = random_electrodes(1 + static_cast<int>(f % 4), random);
    read_noise(changes.row(f), dead, random);
    const FrameCheck::Verdict verdict = check().judge(changes.row(f).data());
    EXPECT_NE(verdict.reasons, 0);
    found += verdict.reasons == dead_electrode &&
             pairs_without({}, verdict.dead) == pairs_without({}, dead);
  }
  EXPECT_GE(found, 396);
}

TEST_F(Check, ImputesDeadChannelsNearerThanTheMean) {
  // Without any knowledge the error is the change itself.
  const std::map<int, double> most = {{1, 0.5}, {2, 0.7}, {4, 0.85}};
  for (const auto& [count, limit] : most) {
    const Frames truth = fresh_changes(200);
    Frames changes = truth;
    RandomStream random(3, 0, 0, Purpose::scene);
    double error = 0;
    double lost = 0;
    for (Eigen::Index f = 0; f < changes.rows(); ++f) {
      const ElectrodeSet dead = random_electrodes(count, random);
      read_zero(changes.row(f), dead);
      const Eigen::RowVectorXd broken = changes.row(f);
      check().impute(changes.row(f).data(), dead);
      const Eigen::ArrayXd same = (broken.array() == changes.row(f).array()).cast<double>();
      error += (changes.row(f) - truth.row(f)).squaredNorm();
      lost += ((1 - same) * truth.row(f).transpose().array()).square().sum();
      // Live channels keep their readings.
      const auto left = pairs_without({}, dead);
      EXPECT_GE(same.sum(), 2 * static_cast<double>(left.size()));
    }
    EXPECT_LT(error, limit * lost) << count;
  }
}

TEST_F(Check, ImputesChannelsThatAreLeftOutAsThoseOfDeadElectrodes) {
  constexpr ElectrodeSet dead = 1u << 2 | 1u << 7;
  const auto pairs = reciprocal_pairs(Sensor{});
  std::vector<int> kept;
  for (const Eigen::Index p : pairs_without({}, dead)) {
    for (const int channel : pairs[static_cast<std::size_t>(p)]) kept.push_back(channel);
  }
  const int alone = kept.back();
  const int reciprocal = kept[kept.size() - 2];
  const Frames changes = fresh_changes(20);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    Eigen::RowVectorXd left_out = changes.row(f);
    Eigen::RowVectorXd expected = changes.row(f);
    expected[alone] = expected[reciprocal];
    check().impute(expected.data(), dead);
    std::vector<int> without = kept;
    without.pop_back();
    check().impute(left_out.data(), without);
    EXPECT_EQ(left_out, expected) << f;
  }
}

TEST_F(Check, FindsNoiseAboveWhatItKnows) {
  EXPECT_EQ(share(fresh_changes(400, 30), noise), 1);
  EXPECT_GE(share(fresh_changes(400, 44), noise), 0.99);  // twice the noise
  EXPECT_LE(share(fresh_changes(400, 56)), 0.01);         // half of it
}

TEST_F(Check, FindsWhatIsOutOfRange) {
  const auto disc = [](double radius, double ratio) {
    return nlohmann::json{
        {"contacts", 1}, {"shapes", {"disc"}}, {"radius", radius}, {"conductivity_ratio", ratio}};
  };
  EXPECT_LE(share(of_scene(disc(0.2, 0.6))), 0.02);
  EXPECT_GE(share(of_scene(disc(0.3, 2)), out_of_range), 0.99);         // a rise of conductivity
  EXPECT_GE(share(of_scene(disc(0.8, 0.1)), out_of_range), 0.99);       // larger than any
  EXPECT_GE(share(of_scene(disc(0.2, 0.6), 0.1), out_of_range), 0.99);  // a stale reference
  EXPECT_GE(share(of_scene(disc(0.2, 0.6), -0.1), out_of_range), 0.95);
}

TEST_F(Check, IsTheSameWhenUnpacked) {
  const FrameCheck again({}, 0, check().packed());
  Frames changes = fresh_changes(300);
  changes.topRows(100) *= 3;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    EXPECT_EQ(again.judge(changes.row(f).data()).reasons,
              check().judge(changes.row(f).data()).reasons);
  }
  const Eigen::VectorXd packed = check().packed();
  EXPECT_THROW(FrameCheck({}, 0, packed.head(packed.size() - 1)), std::invalid_argument);
  EXPECT_THROW(FrameCheck({}, 0, packed.head(100)), std::invalid_argument);
}

TEST_F(Check, LeavesMaskedElectrodesOutOfAccount) {
  const ElectrodeSet masked = 1u << 3 | 1u << 9;
  const ValidationFile validation;
  const FrameCheck check(validation.input(), masked);
  Frames changes = fresh_changes(200);
  RandomStream random(3, 0, 0, Purpose::scene);
  int alarms = 0;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    read_noise(changes.row(f), masked, random);
    alarms += check.judge(changes.row(f).data()).reasons != 0;
    read_zero(changes.row(f), 1u << 6);
    EXPECT_EQ(check.judge(changes.row(f).data()).dead, ElectrodeSet{1} << 6);
  }
  EXPECT_LE(alarms, 4);
}

TEST_F(Check, WithoutFramesFindsDeadElectrodesAlone) {
  const FrameCheck check(Sensor{}, 0);
  Frames changes = fresh_changes(100, 20);
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    EXPECT_EQ(check.judge(changes.row(f).data()).reasons, 0);
    read_zero(changes.row(f), 1);
    EXPECT_EQ(check.judge(changes.row(f).data()).reasons, dead_electrode);
  }
}

TEST_F(Check, WorksOnManyElectrodes) {
  Sensor sensor;
  sensor.electrode_count = 32;
  sensor.electrode_offset = 0;
  sensor.image_grid = 16;
  const FrameCheck check(sensor, 0);
  const Eigen::VectorXd reference = ForwardModel(sensor, 16).reference_voltages();
  const Eigen::VectorXd all_dead = -reference;
  EXPECT_EQ(check.judge(all_dead.data()).reasons, dead_electrode);
  EXPECT_EQ(size_of(check.judge(all_dead.data()).dead), 16);  // every second one explains it
}

TEST(TailLimit, IsTheQuantileOfAPowerLaw) {
  // Of uniform u, u^(-1/4) is above x with probability x^-4.
  RandomStream random(4, 0, 0, Purpose::scene);
  const Eigen::VectorXd values =
      Eigen::VectorXd::NullaryExpr(20000, [&] { return std::pow(1 - random.uniform(), -0.25); });
  // The exponent is known to 1/sqrt(2000) of itself, 0.25: ln 100 times that is 2.6 %.
  EXPECT_NEAR(tail_limit(values, 1e-3), std::pow(1e-3, -0.25), 3 * 0.026 * 5.6);
}

TEST(TailLimit, IsTheQuantileOfLighterTails) {
  RandomStream random(5, 0, 0, Purpose::scene);
  const auto limit = [&](auto&& draw) {
    return tail_limit(Eigen::VectorXd::NullaryExpr(20000, draw), 1e-3);
  };
  EXPECT_NEAR(limit([&] { return std::abs(random.normal()); }), 3.29, 0.15);
  EXPECT_NEAR(limit([&] { return random.uniform(); }), 0.999, 0.003);
}

TEST(TailLimit, KeepsALumpOfTheTailInside) {
  Eigen::VectorXd values(1000);
  for (Eigen::Index i = 0; i < 1000; ++i)
    values[i] = i < 30 ? 10 : 1 + 1e-3 * static_cast<double>(i);
  EXPECT_GE(tail_limit(values, 1e-3), 10);
}

TEST(FrameLimits, OfOneFrameAreItsOwnAndOfNoneAreRefused) {
  const Eigen::VectorXd none(0);
  EXPECT_EQ(tail_limit(Eigen::VectorXd::Constant(1, 2.5), 1e-3), 2.5);
  EXPECT_THROW(tail_limit(none, 1e-3), std::invalid_argument);

  const Eigen::VectorXd one = Eigen::VectorXd::Constant(1, 3);
  const UsualLevel level = UsualLevel::of(one, one, 1e-6, 1e-3);
  EXPECT_DOUBLE_EQ(level.relative(3, 3), 1);
  EXPECT_EQ(level.limit, 1);
  EXPECT_THROW(UsualLevel::of(none, none, 1e-6, 1e-3), std::invalid_argument);

  const Eigen::MatrixXd frame = Eigen::RowVector3d(1, 2, 3);
  const auto directions = PrincipalDirections::of(frame, 1e-6);
  EXPECT_EQ(directions.mean, frame.row(0).transpose());
  EXPECT_EQ(directions.rows.rows(), 0);
  const auto place = directions.place(Eigen::VectorXd(Eigen::Vector3d(1, 0, 0)));
  EXPECT_EQ(place.outside, 1);
  EXPECT_EQ(place.distance, 0);
  EXPECT_THROW(PrincipalDirections::of(Eigen::MatrixXd(0, 3), 1e-6), std::invalid_argument);
}

TEST(UsualLevel, SeparatesAFixedLevelFromAShareOfTheSignal) {
  RandomStream random(6, 0, 0, Purpose::scene);
  Eigen::VectorXd q(2000);
  Eigen::VectorXd s(2000);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    s[i] = std::pow(10, random.uniform(-2, 2));
    q[i] = (3 + 0.5 * s[i]) * (1 + 0.1 * random.normal());
  }
  const UsualLevel level = UsualLevel::of(q, s, 1e-9, 1e-3);
  EXPECT_NEAR(level.a, 3, 0.1);
  EXPECT_NEAR(level.b, 0.5, 0.02);
  EXPECT_GT(level.limit, 1.2);
  EXPECT_LT(level.limit, 1.6);
}

}  // namespace
}  // namespace ertbench
