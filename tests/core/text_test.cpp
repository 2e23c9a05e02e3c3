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

TEST(Text, OverlongFormsAndSurrogatesAreNoCharacters) {
  // "<" in two and three bytes, U+D800, U+110000: RFC 3629 has none of them.
  EXPECT_EQ(code_points("\xe0\x80\xbc"), (std::vector<char32_t>{0xfffd}));
  EXPECT_EQ(code_points("\xed\xa0\x80"), (std::vector<char32_t>{0xfffd}));
  EXPECT_EQ(code_points("\xf4\x90\x80\x80"), (std::vector<char32_t>{0xfffd}));
}

TEST(Text, PrintableHasNothingThatATerminalObeys) {
  EXPECT_EQ(printable("σ of the sheet, S/m"), "σ of the sheet, S/m");
  EXPECT_EQ(printable("a\tb\r\nc"), "a b  c");
  EXPECT_EQ(printable("\x1b[31mred\x7f\x01"), "\ufffd[31mred\ufffd\ufffd");
  EXPECT_EQ(printable("\xc2\x9b\x33\x31m"), "\ufffd31m");  // CSI in one character
  EXPECT_EQ(printable("a\u202eb\u2066c\u2069"), "a\ufffdb\ufffdc\ufffd");
  EXPECT_EQ(printable("\xff\xc3"), "\ufffd\ufffd");
  EXPECT_EQ(printable_lines("a\r\nb\x1b"), "a \nb\ufffd");
}

TEST(Text, PrintableIsCutBetweenCharacters) {
  EXPECT_EQ(printable("δσδσ", 4), "δσδσ");
  EXPECT_EQ(printable("δσδσ", 3), "δσδ…");
  EXPECT_EQ(printable("😀😀😀", 2), "😀😀…");
  EXPECT_EQ(character_count(printable(std::string(5000, '\xff'))), 201U);
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
