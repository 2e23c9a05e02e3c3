#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/errors.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {
namespace {

TEST(Characters, AreThirtySixInTheirBox) {
  const std::string expected = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";
  std::string symbols;
  for (const Character& one : characters()) {
    symbols += one.symbol;
    ASSERT_FALSE(one.strokes.empty()) << one.symbol;
    double lowest = 60;
    double highest = -60;
    for (const auto& stroke : one.strokes) {
      ASSERT_GE(stroke.size(), 2u) << one.symbol;
      for (const Eigen::Vector2d& point : stroke) {
        EXPECT_LE(point.cwiseAbs().maxCoeff(), 60 + 1e-9) << one.symbol;
        lowest = std::min(lowest, point.y());
        highest = std::max(highest, point.y());
      }
      for (std::size_t i = 1; i < stroke.size(); ++i) {
        EXPECT_GT((stroke[i] - stroke[i - 1]).norm(), 0.1) << one.symbol;
      }
    }
    EXPECT_GT(highest - lowest, 110) << one.symbol;  // all of one size
  }
  EXPECT_EQ(symbols, expected);
}

TEST(Characters, AreFoundByTheirSymbol) {
  EXPECT_EQ(character('L').strokes.size(), 1u);
  EXPECT_EQ(character('T').strokes.size(), 2u);
  try {
    character('a');
    FAIL();
  } catch (const InputError& e) {
    EXPECT_STREQ(e.what(), "no character \"a\"; there are 0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ");
  }
}

}  // namespace
}  // namespace ertbench
