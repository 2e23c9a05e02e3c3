// Who is who in two sets, and how far the sets are apart: by hand and by all permutations.

#include "bench/score/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace ertbench {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Places = std::vector<Vector2d>;
using Pairs = std::vector<std::array<int, 2>>;

/// The least sum over all ways to give each row of `distances` [n, m], n <= m, a column of its own.
double least_of_all(const MatrixXd& distances, double cutoff) {
  std::vector<int> columns(static_cast<std::size_t>(distances.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  double least = std::numeric_limits<double>::infinity();
  do {
    double sum = 0;
    for (Eigen::Index i = 0; i < distances.rows(); ++i) {
      sum += std::min(cutoff, distances(i, columns[static_cast<std::size_t>(i)]));
    }
    least = std::min(least, sum);
  } while (std::next_permutation(columns.begin(), columns.end()));
  return least;
}

TEST(Assignment, TakesTheLeastSumAndNotTheNearestFirst) {
  // The nearest pair of all, (0, 0) at 1, would leave 10 to row 1: 11 against 2 + 3.
  MatrixXd distances(2, 2);
  distances << 1, 2, 3, 10;
  const Assignment found = assign(distances, 50);
  EXPECT_EQ(found.pairs, (Pairs{{0, 1}, {1, 0}}));
  EXPECT_DOUBLE_EQ(found.cost, 5);
  // With a cut-off of 3.5 the other way costs 1 + 3.5, and its far pair is none.
  const Assignment cut = assign(distances, 3.5);
  EXPECT_EQ(cut.pairs, (Pairs{{0, 0}}));
  EXPECT_DOUBLE_EQ(cut.cost, 4.5);
}

TEST(Assignment, OfNothingIsEmpty) {
  EXPECT_TRUE(assign(MatrixXd(0, 3), 1).pairs.empty());
  EXPECT_EQ(assign(MatrixXd(3, 0), 1).cost, 0);
}

TEST(Assignment, PlacesThatAreNoNumbersHaveNoPartner) {
  MatrixXd distances(2, 1);
  distances << std::nan(""), 4;
  EXPECT_EQ(assign(distances, 5).pairs, (Pairs{{1, 0}}));
  EXPECT_TRUE(assign(distances.topRows(1), 5).pairs.empty());
}

TEST(Assignment, IsTheBestOfAllPermutations) {
  std::mt19937 random(20260801);
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(trial);
    const auto n = static_cast<Eigen::Index>(1 + random() % 5);
    const auto m = n + static_cast<Eigen::Index>(random() % 3);
    MatrixXd distances(n, m);
    // Whole numbers make ties.
    for (double& d : distances.reshaped()) d = static_cast<double>(random() % 20);
    const double cutoff = 3 + static_cast<double>(random() % 20);
    const double least = least_of_all(distances, cutoff);
    const Assignment found = assign(distances, cutoff);
    EXPECT_NEAR(found.cost, least, 1e-9);
    EXPECT_NEAR(assign(distances.transpose(), cutoff).cost, least, 1e-9);
    double cost = cutoff * static_cast<double>(n - static_cast<Eigen::Index>(found.pairs.size()));
    std::vector<int> columns;
    for (const auto& [row, column] : found.pairs) {
      EXPECT_LE(distances(row, column), cutoff);
      cost += distances(row, column);
      columns.push_back(column);
    }
    EXPECT_NEAR(cost, least, 1e-9) << "the pairs are those of the sum";
    std::sort(columns.begin(), columns.end());
    EXPECT_EQ(std::adjacent_find(columns.begin(), columns.end()), columns.end());
  }
}

TEST(Ospa, ByHand) {
  const Places none;
  const Places one = {Vector2d(0, 0)};
  const Places two = {Vector2d(3, 4), Vector2d(100, 0)};
  EXPECT_EQ(ospa(none, none, 50), 0);
  EXPECT_EQ(ospa(one, none, 50), 50);
  EXPECT_EQ(ospa(none, two, 50), 50);
  EXPECT_EQ(ospa(one, one, 50), 0);
  // (5 + 50) / 2, either way round.
  EXPECT_DOUBLE_EQ(ospa(one, two, 50), 27.5);
  EXPECT_DOUBLE_EQ(ospa(two, one, 50), 27.5);
  // (3 + min(50, 60)) / 2.
  EXPECT_DOUBLE_EQ(ospa(two, Places{Vector2d(3, 7), Vector2d(40, 0)}, 50), 26.5);
}

TEST(Ospa, IsAMetric) {
  std::mt19937 random(20260802);
  std::uniform_real_distribution<double> place(-100, 100);
  const auto places = [&] {
    Places out(random() % 5);
    for (Vector2d& p : out) p = {place(random), place(random)};
    return out;
  };
  for (int trial = 0; trial < 300; ++trial) {
    const Places a = places();
    const Places b = places();
    const Places c = places();
    EXPECT_NEAR(ospa(a, b, 50), ospa(b, a, 50), 1e-9);
    EXPECT_LE(ospa(a, c, 50), ospa(a, b, 50) + ospa(b, c, 50) + 1e-9);
    EXPECT_LE(ospa(a, b, 50), 50);
  }
}

}  // namespace
}  // namespace ertbench
