#include <gtest/gtest.h>

#include "solvers/linear/linear_solver.h"
#include "solvers/solver.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

json with(json spec, const char* key, const json& value) {
  spec[key] = value;
  return spec;
}

class LinearInferenceOf : public ::testing::TestWithParam<json> {};

/// 104 products, each rounded to 2^-24, and a matrix rounded as much: 1e-6 is over ten times that.
TEST_P(LinearInferenceOf, SinglePrecisionRoundsTheImage) {
  const Frames changes = random_changes(40);
  const Images expected = reconstruct(*fitted(GetParam()), changes).images;
  const auto single = fitted(with(GetParam(), "inference_precision", "float32"));
  for (const Eigen::Index batch : {Eigen::Index{1}, changes.rows()}) {
    const Images images = reconstruct(*single, changes.topRows(batch)).images;
    const double difference = relative_difference(images, expected.topRows(batch));
    EXPECT_LT(difference, 1e-6);
    EXPECT_GT(difference, 1e-10) << "was it not single precision?";
  }
}

TEST_P(LinearInferenceOf, AveragingReciprocalPairsIsExact) {
  const Frames changes = random_changes(40);
  const Images expected = reconstruct(*fitted(GetParam()), changes).images;
  const auto all = fitted(with(GetParam(), "inference_averaging", false));
  for (const Eigen::Index batch : {Eigen::Index{1}, changes.rows()}) {
    EXPECT_LT(relative_difference(reconstruct(*all, changes.topRows(batch)).images,
                                  expected.topRows(batch)),
              1e-12);
  }
}

/// Where channels have no partners there is nothing to average.
TEST_P(LinearInferenceOf, AveragingIsNothingWherePairsAreSingle) {
  Sensor sensor;
  sensor.drive.kind = PairPattern::Kind::opposite;
  json spec = GetParam();
  if (spec.value("rank", 0) > 70) spec["rank"] = 70;  // of a numerical rank of 76
  const Frames changes = random_matrix(5, sensor.channels(), 3);
  const Images expected = reconstruct(*fitted(spec, sensor), changes, sensor).images;
  const auto all = fitted(with(spec, "inference_averaging", false), sensor);
  EXPECT_LT(relative_difference(reconstruct(*all, changes, sensor).images, expected), 1e-12);
}

/// The file holds the fit alone: each reader applies it in its own way.
TEST_P(LinearInferenceOf, IsNotInTheFittedFile) {
  const TemporaryFolder folder;
  const json single = with(GetParam(), "inference_precision", "float32");
  fitted(single)->save(folder / "solver.h5");
  const Frames changes = random_changes(3);
  const auto plain = make_solver(GetParam());
  plain->load(folder / "solver.h5", Sensor{});
  EXPECT_EQ(reconstruct(*plain, changes).images, reconstruct(*fitted(GetParam()), changes).images);
  const auto again = make_solver(single);
  again->load(folder / "solver.h5", Sensor{});
  EXPECT_EQ(reconstruct(*again, changes).images, reconstruct(*fitted(single), changes).images);
}

INSTANTIATE_TEST_SUITE_P(Solvers, LinearInferenceOf,
                         ::testing::Values(json{{"type", "one-step-gn"}, {"lambda", 0.1}},
                                           json{{"type", "tsvd"}, {"rank", 20}},
                                           json{{"type", "tsvd"}, {"rank", 104}}),
                         [](const auto& instance) {
                           return instance.param["type"] == "tsvd"
                                      ? "rank" + instance.param["rank"].dump()
                                      : std::string("gauss_newton");
                         });

TEST(ImageMap, KeepsTheFactorsWhileTheyAreSmaller) {
  const auto map = [](Eigen::Index rank) {
    return smaller_map(Eigen::MatrixXd::Ones(576, rank), Eigen::MatrixXd::Ones(rank, 104));
  };
  // 680 rank < 59904 up to rank 88.
  EXPECT_TRUE(map(88).factored());
  EXPECT_EQ(map(88).size(), 680 * 88);
  EXPECT_FALSE(map(89).factored());
  EXPECT_EQ(map(89).left(0, 0), 89);
  EXPECT_EQ(map(89).inputs(), map(88).inputs());
}

}  // namespace
}  // namespace ertbench
