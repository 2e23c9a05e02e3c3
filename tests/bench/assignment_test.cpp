#include "bench/contacts/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

namespace ertbench {
namespace {

TEST(Assignment, IsTheBestOfAllPermutations) {
  std::mt19937 random(1);  // of which every platform has the same numbers
  for (int round = 0; round < 500; ++round) {
    const auto rows = static_cast<Eigen::Index>(1 + random() % 5);
    const auto columns = static_cast<Eigen::Index>(1 + random() % 5);
    Eigen::MatrixXd distance(rows, columns);
    for (double& d : distance.reshaped()) d = static_cast<double>(random() % 100);
    const double cutoff = 60;
    // The shorter side's members go to all choices of the longer side's.
    const Eigen::MatrixXd cost =
        (rows <= columns ? distance : Eigen::MatrixXd(distance.transpose())).cwiseMin(cutoff);
    std::vector<int> order(static_cast<std::size_t>(cost.cols()));
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
    double least = 1e300;
    do {
      double sum = 0;
      for (Eigen::Index i = 0; i < cost.rows(); ++i) {
        sum += cost(i, order[static_cast<std::size_t>(i)]);
      }
      least = std::min(least, sum);
    } while (std::next_permutation(order.begin(), order.end()));

    const auto pairs = assign(distance, cutoff);
    double sum = cutoff * static_cast<double>(cost.rows() - std::ssize(pairs));
    std::set<int> used_rows;
    std::set<int> used_columns;
    for (const auto& [row, column] : pairs) {
      sum += distance(row, column);
      EXPECT_LT(distance(row, column), cutoff);
      used_rows.insert(row);
      used_columns.insert(column);
    }
    EXPECT_EQ(sum, least);
    EXPECT_EQ(used_rows.size(), pairs.size());
    EXPECT_EQ(used_columns.size(), pairs.size());
  }
  EXPECT_TRUE(assign(Eigen::MatrixXd(0, 3), 1).empty());
}

}  // namespace
}  // namespace ertbench
