#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/random.h"
#include "forward/fem/forward_model.h"
#include "solvers/total_variation/interior_point.h"
#include "solvers/total_variation/total_variation.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

/// A of PixelEdges, by its definition.
Eigen::MatrixXd edge_matrix(int n) {
  const PixelEdges edges(n);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(edges.count(), edges.pixels());
  Eigen::Index e = 0;
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c + 1 < n; ++c, ++e) {
      a(e, c + n * r) = -1;
      a(e, c + 1 + n * r) = 1;
    }
  }
  for (int r = 0; r + 1 < n; ++r) {
    for (int c = 0; c < n; ++c, ++e) {
      a(e, c + n * r) = -1;
      a(e, c + n * (r + 1)) = 1;
    }
  }
  return a;
}

Eigen::VectorXd random_vector(Eigen::Index size, std::uint64_t seed) {
  RandomStream random(seed, 0, 0, Purpose::scene);
  return Eigen::VectorXd::NullaryExpr(size, [&] { return random.normal(); });
}

/// Weights spread evenly over `decades`, ending at 1.
Eigen::VectorXd random_weights(Eigen::Index size, double decades) {
  RandomStream random(3, 0, 0, Purpose::scene);
  return Eigen::VectorXd::NullaryExpr(size,
                                      [&] { return std::pow(10.0, -decades * random.uniform()); });
}

class EveryGrid : public ::testing::TestWithParam<int> {};

TEST_P(EveryGrid, DifferencesAndTheirTranspose) {
  const int n = GetParam();
  const PixelEdges edges(n);
  const Eigen::MatrixXd a = edge_matrix(n);
  const Eigen::VectorXd x = random_vector(edges.pixels(), 1);
  const Eigen::VectorXd y = random_vector(edges.count(), 2);
  Eigen::VectorXd ax(edges.count());
  Eigen::VectorXd aty(edges.pixels());
  edges.differences(x, ax);
  edges.transposed(y, aty);
  EXPECT_LT((ax - a * x).norm(), 1e-13);
  EXPECT_LT((aty - a.transpose() * y).norm(), 1e-13);
}

TEST_P(EveryGrid, FactorsALaplacian) {
  const int n = GetParam();
  const PixelEdges edges(n);
  const Eigen::MatrixXd a = edge_matrix(n);
  for (const double decades : {0.0, 4.0}) {
    const Eigen::VectorXd weights = random_weights(edges.count(), decades);
    GridLaplacian laplacian(n);
    laplacian.factor(edges, weights);
    const Eigen::Index m = laplacian.unknowns();
    const Eigen::MatrixXd h = (a.transpose() * weights.asDiagonal() * a).topLeftCorner(m, m);

    Eigen::VectorXd x = random_vector(edges.pixels(), 5);
    const Eigen::VectorXd right = x.head(m);
    laplacian.half_solve(x);
    laplacian.half_solve_transposed(x);
    EXPECT_LT((h * x.head(m) - right).norm(), 1e-11 * h.norm() * x.norm());

    // (L^-1 B)^T (L^-1 B) = B^T H^-1 B.
    const Eigen::Index columns = 2 * GridLaplacian::block;
    RowMajorMatrix b(edges.pixels(), columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      b.col(c) = random_vector(edges.pixels(), 10 + static_cast<std::uint64_t>(c));
    }
    RowMajorMatrix half(m, columns);
    laplacian.half_solve(b, columns, half);
    const Eigen::MatrixXd expected = b.topRows(m).transpose() * h.llt().solve(b.topRows(m));
    EXPECT_LT(testing::relative_difference(half.transpose() * half, expected), 1e-9);

    // L^-T of these: H^-1 B.
    laplacian.half_solve_transposed(half, columns);
    EXPECT_LT(testing::relative_difference(half, h.llt().solve(b.topRows(m))), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(Grids, EveryGrid, ::testing::Values(4, 7, 8, 13, 24, 25));

TEST(Gram, IsTheProductOfTheTransposeWithTheMatrix) {
  for (const Eigen::Index columns : {8, 16, 24, 40, 64, 112}) {
    for (const Eigen::Index rows : {1, 63, 64, 575}) {
      const RowMajorMatrix tall = Eigen::Map<const RowMajorMatrix>(
          random_vector((rows + 1) * columns, 7).data(), rows + 1, columns);
      Eigen::MatrixXd sum = Eigen::MatrixXd::Identity(columns, columns);
      add_gram(tall, rows, sum);
      const Eigen::MatrixXd expected = Eigen::MatrixXd::Identity(columns, columns) +
                                       tall.topRows(rows).transpose() * tall.topRows(rows);
      const Eigen::MatrixXd lower = sum.triangularView<Eigen::Lower>();
      const Eigen::MatrixXd expected_lower = expected.triangularView<Eigen::Lower>();
      EXPECT_LT(testing::relative_difference(lower, expected_lower), 1e-13);
    }
  }
}

TEST(GridLaplacian, IsAccurateHoweverTheWeightsSpread) {
  // Conductances in a chain from pixel 0 to pixel 3, the one held: a unit current into pixel 0
  // raises every pixel by the resistances between it and pixel 3.
  const int n = 2;
  const PixelEdges edges(n);
  // Pixels 0 1 / 2 3, edges 0-1, 2-3, 0-2, 1-3. With 0-2 next to nothing the chain is 0-1-3.
  Eigen::VectorXd weights(4);
  weights << 1e-12, 1.0, 1e-40, 1e12;
  GridLaplacian laplacian(n);
  laplacian.factor(edges, weights);
  Eigen::VectorXd x = Eigen::VectorXd::Unit(4, 0);  // unit current into pixel 0, out of pixel 3
  laplacian.half_solve(x);
  laplacian.half_solve_transposed(x);
  EXPECT_NEAR(x[0], 1e12 + 1e-12, 1e-3);
  EXPECT_NEAR(x[1], 1e-12, 1e-26);  // an ordinary Cholesky loses this beside 1e12
}

TEST(NewtonSystem, SolvesItsEquations) {
  const TotalVariation problem{Sensor{}};
  const Eigen::MatrixXd a = edge_matrix(24);
  const Eigen::VectorXd right = random_vector(576, 8);
  NewtonSystem system(problem);
  for (const Eigen::Index channels : {16, 64, 112}) {
    const Eigen::MatrixXd j = problem.jacobian_transposed().leftCols(channels).transpose();
    for (const double decades : {0.0, 6.0}) {
      const Eigen::VectorXd weights = 1e-3 * random_weights(problem.edges().count(), decades);
      ASSERT_TRUE(system.factor(weights, channels));
      Eigen::VectorXd x(576);
      system.solve(right, x);
      const Eigen::MatrixXd matrix = a.transpose() * weights.asDiagonal() * a + j.transpose() * j;
      EXPECT_LT((matrix * x - right).norm(), 1e-9 * (right.norm() + matrix.norm() * x.norm()))
          << channels << " channels, " << decades << " decades";
      const Eigen::VectorXd expected = matrix.ldlt().solve(right);
      EXPECT_LT(testing::relative_difference(x, expected), 1e-6);
    }
  }
}

TEST(TotalVariation, KeepsTheProblemInItsBasis) {
  const Sensor sensor;
  const TotalVariation problem{sensor};
  const Eigen::MatrixXd jacobian = ForwardModel(sensor, 24).jacobian();
  const Frames changes = testing::random_changes(2);
  const Eigen::VectorXd x = 0.01 * random_vector(576, 9);
  const Eigen::VectorXd residual =
      problem.scale() * (problem.jacobian_transposed().transpose() * x) -
      problem.project(changes.row(0));
  // |J x - d|^2 less what reciprocal channels differ by, which no image changes.
  double antisymmetric = 0;
  for (const auto& [p, q] : reciprocal_pairs(sensor)) {
    antisymmetric += std::pow(changes(0, p) - changes(0, q), 2) / 2;
  }
  const double expected = (jacobian * x - changes.row(0).transpose()).squaredNorm() - antisymmetric;
  EXPECT_NEAR(residual.squaredNorm(), expected, 1e-12 * expected);
}

}  // namespace
}  // namespace ertbench
