// The experiment on KTC2023's files: score, tank, calibration and methods, on files of the same
// structure that are written here.

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/errors.h"
#include "core/files.h"
#include "forward/data/sheet_model.h"
#include "tests/bench/ktc2023_testing.h"

namespace ertbench {
namespace {

ClassMap square_map(int kind, int low, int high) {
  ClassMap map = ClassMap::Zero(256, 256);
  map.block(low, low, high - low, high - low).setConstant(kind);
  return map;
}

TEST(KtcScore, IsOneForEqualMapsAndTreatsBothClassesAndBothMapsAlike) {
  ClassMap a = square_map(1, 40, 90);
  a.block(150, 100, 40, 60).setConstant(2);
  const ClassMap b = square_map(2, 120, 200);
  EXPECT_NEAR(ktc_score(a, a), 1, 1e-12);
  EXPECT_NEAR(ktc_score(a, b), ktc_score(b, a), 1e-12);
  const auto exchanged = [](const ClassMap& map) -> ClassMap {
    return map.unaryExpr([](int c) { return c == 0 ? 0 : 3 - c; });
  };
  EXPECT_NEAR(ktc_score(a, b), ktc_score(exchanged(a), exchanged(b)), 1e-12);
  EXPECT_LT(ktc_score(a, b), 0.5);
}

TEST(KtcScore, SimilarityIsThatComputedByHand) {
  const double c1 = 1e-4;
  const double c2 = 9e-4;
  const Eigen::RowVector2d left(1, 0);
  const Eigen::RowVector2d right(0, 1);
  const Eigen::RowVector2d none(0, 0);
  // Under a window that is flat over both pixels all means are 1/2, so that the covariance is -1/4
  // and the variances are 1/4 each.
  EXPECT_NEAR(mean_similarity(left, right, 1e6), (0.5 + c1) * (-0.5 + c2) / (0.5 + c1) / (0.5 + c2),
              1e-9);
  // Equal everywhere: only the means differ.
  EXPECT_NEAR(mean_similarity(Eigen::MatrixXd::Ones(9, 9), Eigen::MatrixXd::Zero(9, 9)),
              c1 / (1 + c1), 1e-12);
  // Window exp(-x^2 / 2): the weights of two pixels are normalised at the border.
  double expected = 0;
  for (const double p : {1 / (1 + std::exp(-0.5)), std::exp(-0.5) / (1 + std::exp(-0.5))}) {
    expected += c1 * c2 / ((p * p + c1) * (p - p * p + c2)) / 2;
  }
  EXPECT_NEAR(mean_similarity(left, none, 1), expected, 1e-12);
  // Beyond two widths there is no weight: the far pixel sees no difference.
  Eigen::RowVectorXd dot = Eigen::RowVectorXd::Zero(4);
  dot[0] = 1;
  const Eigen::RowVectorXd empty = Eigen::RowVectorXd::Zero(4);
  const double w1 = std::exp(-0.5);
  const double w2 = std::exp(-2.0);
  const double sums[] = {1 + w1 + w2, 1 + 2 * w1 + w2, 1 + 2 * w1 + w2};
  const double weights[] = {1, w1, w2};
  expected = 0.25;
  for (int i = 0; i < 3; ++i) {
    const double p = weights[i] / sums[i];
    expected += c1 * c2 / ((p * p + c1) * (p - p * p + c2)) / 4;
  }
  EXPECT_NEAR(mean_similarity(dot, empty, 1), expected, 1e-12);
}

TEST(KtcScore, OtsuTakesTheLargestClassForWater) {
  Eigen::MatrixXd image = Eigen::MatrixXd::Zero(20, 20);
  image.block(2, 2, 3, 3).setConstant(-1);
  image.block(10, 10, 4, 4).setConstant(1.5);
  EXPECT_EQ(otsu_classes(image)(3, 3), 1);
  EXPECT_EQ(otsu_classes(image)(12, 12), 2);
  EXPECT_EQ((otsu_classes(image).array() == 0).count(), 400 - 9 - 16);
  EXPECT_EQ(otsu_classes(image + Eigen::MatrixXd::Constant(20, 20, 7)), otsu_classes(image));
  // Water may be the lowest class: then both others are conductive.
  EXPECT_EQ(otsu_classes(image.cwiseAbs())(3, 3), 2);
  EXPECT_EQ(otsu_classes(Eigen::MatrixXd::Constant(4, 4, 3.0)), ClassMap::Zero(4, 4));
}

TankModel::Solution uniform_tank(double conductivity, double impedance,
                                 const TankModel& model = tank()) {
  return model.solve(Eigen::VectorXd::Constant(std::ssize(model.triangles()), conductivity),
                     Eigen::VectorXd::Constant(TankModel::electrodes, impedance));
}

TEST(KtcTank, AgreesWithTheBorderModelOfCompleteElectrodes) {
  nlohmann::json json = {{"shape", "disc"},
                         {"diameter_mm", 230},
                         {"electrode_model", "complete"},
                         {"contact_impedance", 1e-4},
                         {"electrode_width_mm", 115 * std::numbers::pi / 32},
                         {"drive_current", 1},
                         {"background", 0.7},
                         {"measures_driven", true},
                         {"drive", {{2, 0}, {16, 0}, {13, 8}}}};
  for (int m = 0; m + 1 < TankModel::electrodes; ++m) json["measurement"].push_back({m, m + 1});
  for (int e = 0; e < TankModel::electrodes; ++e) {
    const double angle = (90 + 11.25 * e) * std::numbers::pi / 180;
    json["electrode_points_mm"].push_back({115 * std::cos(angle), 115 * std::sin(angle)});
  }
  const Eigen::VectorXd expected =
      uniform_reference(sensor_from_json(JsonObject(json, "tank", "")));
  KtcPatterns patterns{Eigen::MatrixXd::Zero(32, 3), Eigen::MatrixXd::Zero(32, 31)};
  const int drives[][2] = {{0, 2}, {0, 16}, {8, 13}};
  for (int d = 0; d < 3; ++d) {
    patterns.currents(drives[d][0], d) = 1;
    patterns.currents(drives[d][1], d) = -1;
  }
  for (int m = 0; m < 31; ++m) {
    patterns.measurements(m, m) = 1;
    patterns.measurements(m + 1, m) = -1;
  }
  const Eigen::VectorXd ideal = Eigen::VectorXd::Zero(31);
  const Eigen::MatrixXd channels = channel_operator(patterns, ideal, ideal);
  // Largest errors at pairs that a driven electrode belongs to, and at all others.
  const auto errors = [&](const TankModel& model) {
    const Eigen::VectorXd voltages =
        channels * TankModel::packed(uniform_tank(0.7, 1e-4, model).resistance);
    std::array<double, 2> worst = {0, 0};
    for (Eigen::Index c = 0; c < voltages.size(); ++c) {
      const Eigen::VectorXd current = patterns.currents.col(patterns.drive_of(c));
      double& error =
          worst[current.cwiseProduct(patterns.measurements.col(c % 31)).isZero(0) ? 1 : 0];
      error = std::max(error, std::abs(voltages[c] / expected[c] - 1));
    }
    return worst;
  };
  const auto once = errors(tank());
  const auto twice = errors(TankModel(2));
  EXPECT_LT(once[0], 0.07) << "once";
  EXPECT_LT(once[1], 0.005);
  EXPECT_LT(twice[0], once[0] / 2.5) << once[0];
  EXPECT_LT(twice[1], 0.003) << once[1];
}

TEST(KtcTank, ResistancesScaleAndTurnWithTheTank) {
  const Eigen::MatrixXd one = uniform_tank(1, 1e-4).resistance;
  const Eigen::MatrixXd half = uniform_tank(0.5, 2e-4).resistance;
  EXPECT_LT((half - 2 * one).norm(), 1e-8 * one.norm());
  EXPECT_LT(one.rowwise().sum().norm(), 1e-8 * one.norm());
  for (int e = 1; e < TankModel::electrodes; ++e) {
    EXPECT_NEAR(one(e, (e + 5) % 32), one(0, 5), 1e-8 * one(0, 0));
  }
}

TEST(KtcTank, SensitivitiesAreDerivatives) {
  Eigen::VectorXd conductivity = Eigen::VectorXd::Constant(std::ssize(tank().triangles()), 0.8);
  Eigen::VectorXd impedance = Eigen::VectorXd::Constant(32, 3e-4);
  conductivity.head(400).setConstant(2);
  const TankModel::Solution at = tank().solve(conductivity, impedance);
  constexpr double small = 1e-4;
  for (const Eigen::Index t : {7, 900, 4300}) {
    Eigen::VectorXd other = conductivity;
    other[t] *= 1 + small;
    const Eigen::VectorXd change =
        TankModel::packed(tank().solve(other, impedance).resistance - at.resistance);
    const Eigen::VectorXd expected =
        small * conductivity[t] *
        tank().sensitivity(at, static_cast<std::size_t>(t)).cast<double>();
    EXPECT_LT((change - expected).norm(), 1e-3 * expected.norm()) << t;
  }
  impedance[5] *= std::exp(small);
  const Eigen::VectorXd change =
      TankModel::packed(tank().solve(conductivity, impedance).resistance - at.resistance);
  impedance[5] *= std::exp(-small);
  const Eigen::VectorXd expected = small * tank().impedance_sensitivity(at, impedance).col(5);
  EXPECT_LT((change - expected).norm(), 1e-3 * expected.norm());
}

TEST(KtcCalibration, RecoversTheInstrumentFromTheEmptyTank) {
  const SmallCompetition made;
  const KtcCalibration fit = calibrate_ktc(tank(), made.patterns, made.voltages(false));
  EXPECT_NEAR(fit.conductivity, 0.8, 0.008);
  EXPECT_LT((fit.common_mode - made.common_mode).cwiseAbs().maxCoeff(), 0.002);
  ASSERT_EQ(fit.unexplained.size(), 4u);
  EXPECT_GT(fit.unexplained[1], 0.02);  // without the common mode
  EXPECT_LT(fit.unexplained[3], 0.002);
  // Up to a step all is fitted, and nothing of those behind it.
  const KtcCalibration part =
      calibrate_ktc(tank(), made.patterns, made.voltages(false), "impedances");
  ASSERT_EQ(part.unexplained.size(), 2u);
  EXPECT_NEAR(part.unexplained[1], fit.unexplained[1], 1e-9);
  EXPECT_LT(part.common_mode.norm() + part.gain.norm(), 1e-6);
}

TEST(KtcExperiment, WholeTargetsStandForEveryLevelAndALevelSetFindsThem) {
  const TemporaryFolder folder("ktc");
  const SmallCompetition made;
  made.write_training(folder.path(), [](Eigen::Index) { return 1; });
  const KtcResults results = results_in(
      folder.path(), {{{"type", "level-set"}}, {{"type", "one-step-gn"}}, {{"type", "tsvd"}}}, 2);
  ASSERT_EQ(results.rows.size(), 5u);  // the level set twice, and the empty image
  EXPECT_TRUE(results.simulated_levels);
  const KtcRow& level_set = results.rows[0];
  ASSERT_EQ(level_set.outcomes.size(), 2u);
  EXPECT_GT(*level_set.outcomes[0].score, 0.8);
  EXPECT_GT(*level_set.outcomes[1].score, 0.7);  // eight electrodes fewer
  EXPECT_GT(*results.rows[2].outcomes[0].score, 0.6);
  EXPECT_GT(*results.rows[3].outcomes[0].score, 0.4);
  EXPECT_LT(*results.rows[4].outcomes[0].score, 0.4);
  ASSERT_EQ(results.simulated.size(), 5u);
  ASSERT_EQ(results.simulated[0].outcomes.size(), 4u);  // two targets at two levels
  EXPECT_NE(results.simulated[0].outcomes[0].truth, results.simulated[0].outcomes[2].truth);
  EXPECT_GT(*results.simulated[0].score_of(1), *results.simulated[4].score_of(1) + 0.3);
  EXPECT_FALSE(level_set.sum().has_value());  // five levels are not asked for
  EXPECT_NEAR(*level_set.score_of(5), 3 * *level_set.outcomes[1].score, 1e-12);
}

TEST(KtcExperiment, TheEvaluationsFoldersHaveTheirLevels) {
  const TemporaryFolder folder("ktc");
  const SmallCompetition made;
  for (const int level : {1, 5}) {
    const fs::path own = folder.path() / "evaluation_datasets" / ("level" + std::to_string(level));
    made.write_reference(own);
    made.write_data(own / "data2.mat", level);
  }
  write_mat(folder.path() / "GroundTruths/level5/2_true.mat",
            {{"truth", SmallCompetition::truth()}});
  const std::vector<KtcTarget> targets = read_ktc_targets(folder.path());
  ASSERT_EQ(targets.size(), 2u);
  EXPECT_EQ(targets[1].name, "5.2");
  EXPECT_FALSE(targets[0].truth.has_value());
  ASSERT_TRUE(targets[1].truth.has_value());
  const KtcResults results = results_in(folder.path(), {{{"type", "one-step-gn"}}});
  const KtcRow& row = results.rows.front();
  ASSERT_EQ(row.outcomes.size(), 2u);
  EXPECT_FALSE(row.outcomes[0].score.has_value());  // no truth, no score
  EXPECT_GT(*row.outcomes[1].score, 0.4);
  EXPECT_EQ(row.mean_score(), *row.outcomes[1].score);
}

TEST(KtcExperiment, SaysWhatIsMissing) {
  const TemporaryFolder folder("ktc");
  const auto message = [&](const auto& call) -> std::string {
    try {
      call();
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto read = [&] { read_ktc_targets(folder.path()); };
  EXPECT_NE(message(read).find("ref.mat"), std::string::npos);
  const SmallCompetition made;
  made.write_reference(folder.path());
  EXPECT_NE(message(read).find("data1.mat"), std::string::npos);
  write_mat(folder.path() / "data1.mat", {{"Inj", made.patterns.currents.topRows(16)},
                                          {"Mpat", made.patterns.measurements},
                                          {"Uel", made.voltages(true)}});
  EXPECT_NE(message(read).find("Inj must have 32 rows, it has 16"), std::string::npos);
  EXPECT_NE(message([&] { results_in(folder.path() / "elsewhere", {}); }).find("/data"),
            std::string::npos);
  const fs::path own = folder.path() / "evaluation_datasets/level3";
  made.write_reference(own);
  made.write_data(own / "data1.mat", 3);
  EXPECT_EQ(message([&] {
              results_in(folder.path() / "evaluation_datasets", {{{"type", "one-step-gn"}}});
            }).find("ktc.json: /levels: no target in "),
            0u);
}

}  // namespace
}  // namespace ertbench
