#include <gtest/gtest.h>

#include "core/csv_field.h"

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

}  // namespace
}  // namespace ertbench
