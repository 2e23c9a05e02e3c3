#include <gtest/gtest.h>

#include "core/text.h"

namespace ertbench {
namespace {

TEST(CsvLines, ReadBackWhatFieldsWereWritten) {
  const std::vector<std::string> fields = {"plain", "a, b", "say \"x\"", "two\nlines", ""};
  std::string line;
  for (const std::string& field : fields) line += (line.empty() ? "" : ",") + csv_field(field);
  const auto lines = csv_lines("head,er\r\n" + line + "\nlast");
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0], (std::vector<std::string>{"head", "er"}));
  EXPECT_EQ(lines[1], fields);
  EXPECT_EQ(lines[2], std::vector<std::string>{"last"});
}

TEST(CsvField, NoSpreadsheetComputesIt) {
  EXPECT_EQ(csv_field("=1+1"), "'=1+1");
  EXPECT_EQ(csv_field("@SUM(A1)"), "'@SUM(A1)");
  EXPECT_EQ(csv_field("+cmd"), "'+cmd");
  EXPECT_EQ(csv_field("-cmd|' /C calc'!A0"), "'-cmd|' /C calc'!A0");
  EXPECT_EQ(csv_field("=A1,\"b\""), "\"'=A1,\"\"b\"\"\"");
  EXPECT_EQ(csv_field(" =1"), "' =1");
  EXPECT_EQ(csv_field("\t=1"), "'\t=1");
  EXPECT_EQ(csv_field("\r=1"), "\"'\r=1\"");
}

TEST(CsvField, NumbersAndWordsStayWhatTheyAre) {
  for (const char* text : {"-0.5", "+1e-3", "-12", "one-step-gn", "a=b", "'quoted'", "—", ""}) {
    EXPECT_EQ(csv_field(text), text);
  }
}

TEST(CsvLines, TakeTheApostropheOffAgain) {
  for (const char* text :
       {"=1", "'=1", "''@x", "-x", "-0.5", "'-0.5", "'it", "+", "'", " =1", "' -x"}) {
    EXPECT_EQ(csv_lines(csv_field(text) + ",b\n")[0][0], text);
  }
}

}  // namespace
}  // namespace ertbench
