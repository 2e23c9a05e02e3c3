#include <gtest/gtest.h>

#include <stdexcept>

#include "core/statistics.h"

namespace ertbench {
namespace {

TEST(StudentT, QuantilesAreThoseOfTheTables) {
  // Abramowitz and Stegun, table 26.10.
  EXPECT_NEAR(student_t_quantile(0.975, 1), 12.706, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.995, 4), 4.604, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.9995, 7), 5.408, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.9995, 120), 3.373, 5e-4);
  EXPECT_NEAR(student_t_quantile(0.5, 3), 0, 1e-10);
  EXPECT_NEAR(student_t_quantile(0.025, 10), -2.228, 5e-4);
  EXPECT_THROW(student_t_quantile(1, 3), std::invalid_argument);
  EXPECT_THROW(student_t_quantile(0.5, 0), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
