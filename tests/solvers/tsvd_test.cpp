#include "solvers/linear/tsvd.h"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include "core/errors.h"
#include "core/random.h"
#include "forward/fem/forward_model.h"
#include "solvers/decompositions.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// A matrix with these singular values.
Eigen::MatrixXd with_values(const Eigen::VectorXd& values, Eigen::Index rows, Eigen::Index cols) {
  const auto orthonormal = [&](Eigen::Index size, std::uint64_t seed) -> Eigen::MatrixXd {
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(random_matrix(size, values.size(), seed));
    return qr.householderQ() * Eigen::MatrixXd::Identity(size, values.size());
  };
  return orthonormal(rows, 1) * values.asDiagonal() * orthonormal(cols, 2).transpose();
}

void expect_decomposes(const Eigen::MatrixXd& a, const Eigen::VectorXd& expected,
                       Eigen::Index count) {
  const DenseSvd triplets = singular_triplets(a);
  ASSERT_EQ(triplets.values.size(), count);
  const double rounding = 1e-13 * expected[0];
  EXPECT_LT((triplets.values - expected.head(count)).cwiseAbs().maxCoeff(), rounding);
  const auto s = triplets.values.asDiagonal();
  EXPECT_LT((a * triplets.right - triplets.left * s).norm(), 10 * rounding);
  EXPECT_LT((a.transpose() * triplets.left - triplets.right * s).norm(), 10 * rounding);
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(count, count);
  EXPECT_LT((triplets.left.transpose() * triplets.left - one).norm(), 1e-12);
  EXPECT_LT((triplets.right.transpose() * triplets.right - one).norm(), 1e-12);
}

TEST(SingularTriplets, OfTheJacobianAreThoseOfADenseDecomposition) {
  const Eigen::MatrixXd jacobian = ForwardModel(Sensor{}, 24).jacobian();
  const Eigen::VectorXd values = dense_svd(jacobian).values;
  const Eigen::MatrixXd reduced = Reciprocity(Sensor{}).reduce_rows(jacobian);
  expect_decomposes(reduced, values, 104);
}

TEST(SingularTriplets, FindsEveryCopyOfAValue) {
  Eigen::VectorXd values(30);
  for (int i = 0; i < 30; ++i) values[i] = std::pow(0.5, i / 5);  // each five times
  expect_decomposes(with_values(values, 30, 70), values, 30);
  expect_decomposes(with_values(values, 70, 30), values, 30);
}

TEST(SingularTriplets, KeepsSmallValues) {
  Eigen::VectorXd values(12);
  for (int i = 0; i < 12; ++i) values[i] = std::pow(10, -i);
  const DenseSvd triplets = singular_triplets(with_values(values, 12, 40));
  ASSERT_EQ(triplets.values.size(), 12);
  // To rounding in the largest; squaring the matrix would leave 1e-8.
  EXPECT_LT((triplets.values - values).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(SingularTriplets, ScaleWithTheMatrix) {
  // A current of 1e-9 A into a sheet of 1e8 S/m makes a Jacobian of this size.
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(12, 12, 1);
  const Eigen::MatrixXd a = with_values(values, 12, 40);
  for (const double scale : {1e-25, 1e20}) {
    const Eigen::VectorXd found = singular_triplets(scale * a).values / scale;
    EXPECT_LT((found - values).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(SingularTriplets, StopsAtTheRank) {
  const Eigen::MatrixXd a = with_values(Eigen::Vector3d(3, 2, 1), 20, 50);
  EXPECT_EQ(singular_triplets(a).values.size(), 3);
}

TEST(TruncatedSvd, IsThePseudoinverseOfTheTruncatedJacobian) {
  const Eigen::MatrixXd jacobian = ForwardModel(Sensor{}, 24).jacobian();
  const DenseSvd svd = dense_svd(jacobian);
  const Frames changes = random_changes(3);
  for (const int rank : {1, 20, 45, 70}) {
    const Eigen::MatrixXd expected =
        svd.right.leftCols(rank) * (svd.values.head(rank).cwiseInverse().asDiagonal() *
                                    (svd.left.leftCols(rank).transpose() * changes.transpose()));
    const Images images = reconstruct(*fitted({{"type", "tsvd"}, {"rank", rank}}), changes).images;
    // Rounding, 1e-15, over the smallest value kept (1e-3 at rank 70) and gaps between values.
    EXPECT_LT(relative_difference(images, expected.transpose()), 1e-9) << rank;
  }
}

TEST(TruncatedSvd, AThresholdIsTheRankOfItsValues) {
  const Frames changes = random_changes(3);
  const Images by_threshold =
      reconstruct(*fitted({{"type", "tsvd"}, {"threshold", 0.01}}), changes).images;
  const Images by_rank = reconstruct(*fitted({{"type", "tsvd"}, {"rank", 45}}), changes).images;
  EXPECT_LT(relative_difference(by_threshold, by_rank), 1e-9);
}

TEST(TruncatedSvd, AThresholdKeepsPairsWhole) {
  // The square's symmetry makes values 2 and 3 equal. A threshold at them, up to rounding, takes
  // both or neither: the image of rank 3 or that of rank 1, never that of rank 2.
  const Eigen::MatrixXd reduced =
      Reciprocity(Sensor{}).reduce_rows(ForwardModel(Sensor{}, 24).jacobian());
  const Eigen::VectorXd s = singular_triplets(reduced).values;
  ASSERT_LT(s[1] - s[2], 1e-12 * s[0]);
  const Frames changes = random_changes(3);
  const auto images = [&](const json& spec) { return reconstruct(*fitted(spec), changes).images; };
  const Images both = images({{"type", "tsvd"}, {"rank", 3}});
  const Images neither = images({{"type", "tsvd"}, {"rank", 1}});
  for (const double shift : {-1e-15, 0.0, 1e-15}) {
    const Images cut = images({{"type", "tsvd"}, {"threshold", (s[1] + s[2]) / 2 / s[0] + shift}});
    EXPECT_LT(std::min(relative_difference(cut, both), relative_difference(cut, neither)), 1e-9);
  }
}

TEST(TruncatedSvd, NamesWhatIsWrong) {
  const auto message = [](const json& spec, const Sensor& sensor = {}) {
    return message_of<InputError>([&] { fitted(spec, sensor); });
  };
  const std::string too_high = message({{"type", "tsvd"}, {"rank", 105}});
  EXPECT_EQ(too_high.find("spec.json: /rank: must be <= 104"), 0u) << too_high;
  EXPECT_NE(too_high.find("reciprocal"), std::string::npos) << too_high;
  EXPECT_EQ(message({{"type", "tsvd"}, {"rank", 104}}), "");
  Sensor coarse;
  coarse.image_grid = 8;
  EXPECT_EQ(message({{"type", "tsvd"}, {"rank", 65}}, coarse).find("spec.json: /rank: must be <="),
            0u);
  EXPECT_EQ(message({{"type", "tsvd"}, {"rank", 0}}).find("spec.json: /rank: must be"), 0u);
  EXPECT_EQ(message({{"type", "tsvd"}, {"rank", 2.5}}).find("spec.json: /rank: must be"), 0u);
  EXPECT_EQ(message({{"type", "tsvd"}, {"threshold", 1.0}}).find("spec.json: /threshold: must be"),
            0u);
  EXPECT_EQ(message({{"type", "tsvd"}, {"threshold", 0}}).find("spec.json: /threshold: must be"),
            0u);
  EXPECT_EQ(message({{"type", "tsvd"}, {"rank", 3}, {"threshold", 0.1}}),
            "spec.json: /: give \"rank\" or \"threshold\", not both");
  EXPECT_EQ(message({{"type", "tsvd"}}),
            "spec.json: /rank: \"auto\" needs a validation set; give a number");
}

}  // namespace
}  // namespace ertbench
