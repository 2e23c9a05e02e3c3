#include "core/text.h"

#include <gtest/gtest.h>

#include <limits>

namespace ertbench {
namespace {

using Lines = std::vector<std::string>;

TEST(Text, FixedDecimals) {
  EXPECT_EQ(fixed(1.2345, 3), "1.234");  // 1.2345 lies just below
  EXPECT_EQ(fixed(-0.5, 2), "−0.50");
  EXPECT_EQ(fixed(-0.0004, 3), "0.000");  // no negative nothing
  EXPECT_EQ(fixed(2.5e9, 3), "2.50e+09");
  EXPECT_EQ(fixed(std::numeric_limits<double>::quiet_NaN(), 3), "—");
}

TEST(Text, ThreeDigits) {
  EXPECT_EQ(three_digits(0.012345), "0.0123");
  EXPECT_EQ(three_digits(5.4), "5.40");
  EXPECT_EQ(three_digits(98765), "98765");
  EXPECT_EQ(three_digits(0), "0");
}

TEST(Text, CountsCharacters) {
  EXPECT_EQ(character_count("δσ / c₀"), 7U);
  EXPECT_EQ(code_points("aδ₀😀"), (std::vector<char32_t>{U'a', U'δ', U'₀', U'😀'}));
  EXPECT_EQ(code_points("\xff\xc3"), (std::vector<char32_t>{0xfffd, 0xfffd}));
}

TEST(Text, OneLine) {
  EXPECT_EQ(one_line(" a \n\t b ", 10), "a b");
  EXPECT_EQ(one_line("δσδσ", 3), "δσδ…");
  EXPECT_EQ(one_line("abc", 3), "abc");
}

TEST(Text, Wraps) {
  EXPECT_EQ(wrapped("one-step-gn noser", 12), (Lines{"one-step-gn", "noser"}));
  EXPECT_EQ(wrapped("one-step-gn", 9), (Lines{"one-step-", "gn"}));
  EXPECT_EQ(wrapped("abcdefgh", 3), (Lines{"abc", "def", "gh"}));
  EXPECT_EQ(wrapped("λλ λλ", 2), (Lines{"λλ", "λλ"}));
  EXPECT_EQ(wrapped("", 5), (Lines{""}));
}

TEST(Text, Splits) {
  EXPECT_EQ(split("a, b,, c", ", "), (Lines{"a", "b,", "c"}));
  EXPECT_EQ(split("", "\n"), (Lines{""}));
  EXPECT_EQ(split("\n", "\n"), (Lines{"", ""}));
}

}  // namespace
}  // namespace ertbench
