// One table in all five formats, and what each format must not take for its own.

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>
#include <string>

#include "bench/table/table.h"
#include "tests/bench/figure_testing.h"

namespace ertbench {
namespace {

Table small() {
  Table table;
  table.title = "A title";
  table.text = "First.\n\nSecond.";
  TableSection& section = table.sections.emplace_back();
  section.caption = "rows";
  section.text = "Above.";
  section.columns = {{"name", Align::left}, "value", {"remark", Align::right, 1}};
  Cell value = number_cell(1.25, 1);
  value.interval = interval_text("1.0", "1.5");
  value.lines = {"paper 2.0"};
  Cell failed = "b";
  failed.lines = {"crashed"};
  section.rows = {{"a", value, "λ | 50 %"}, {failed, number_cell(std::nullopt, 1), ""}};
  section.notes = {"Below."};
  table.legend = {"value: its meaning."};
  table.command = "make it";
  return table;
}

TEST(Writers, Markdown) {
  EXPECT_EQ(markdown_of(small()),
            "# A title\n\nFirst.\n\nSecond.\n\n## rows\n\nAbove.\n\n"
            "| name         |                       value |    remark |\n"
            "| :----------- | --------------------------: | --------: |\n"
            "| a            | 1.2 [1.0, 1.5]<br>paper 2.0 | λ \\| 50 % |\n"
            "| b<br>crashed |                           — |           |\n"
            "\nBelow.\n\n- value: its meaning.\n\nTo reproduce it:\n\n```sh\nmake it\n```\n");
}

TEST(Writers, Terminal) {
  EXPECT_EQ(terminal_of(small()),
            "A title\n\nFirst.\n\nSecond.\n\nrows\nAbove.\n"
            "name              value    remark\n"
            "a        1.2 [1.0, 1.5]  λ | 50 %\n"
            "              paper 2.0\n"
            "b                     —\n"
            "crashed\n"
            "    Below.\n\n- value: its meaning.\n\nTo reproduce it: make it\n");
}

TEST(Writers, TerminalLeavesOutTitlesThatAreEmpty) {
  Table table = small();
  for (Column& column : table.sections[0].columns) column.title.clear();
  EXPECT_EQ(terminal_of(table).find("name"), std::string::npos);
  EXPECT_NE(terminal_of(table).find("Above.\na "), std::string::npos) << terminal_of(table);
}

TEST(Writers, CsvHoldsTheNumbersBehindTheTexts) {
  EXPECT_EQ(csv_of(small().sections[0]), "name,value,remark\na,1.25,λ | 50 %\nb,—,\n");
  TableSection quoted;
  quoted.columns = {"a,b"};
  quoted.rows = {{"x \"y\"\nz"}, {exact_cell(0.1 + 0.2)}, {exact_cell(std::nullopt)}};
  EXPECT_EQ(csv_of(quoted), "\"a,b\"\n\"x \"\"y\"\"\nz\"\n0.30000000000000004\n\n");
}

TEST(Writers, LatexHasATabularForEachPart) {
  const std::string out = latex_of(small());
  EXPECT_EQ(testing::count(out, "\\begin{tabular}{@{}lr@{}}"), 2U) << out;
  EXPECT_NE(out.find("\\caption{A title, rows: Above.}"), std::string::npos) << out;
  EXPECT_NE(out.find("{}1.2\\\\{}[1.0, 1.5]\\\\{}paper 2.0\\end{tabular}"), std::string::npos)
      << out;
  EXPECT_NE(out.find("\\ensuremath{\\lambda} \\ensuremath{|} 50 \\%"), std::string::npos) << out;
  EXPECT_EQ(testing::count(out, "crashed"), 1U) << "said in the first part alone";
  EXPECT_EQ(testing::count(out, "\\begin{"), testing::count(out, "\\end{"));
}

TEST(Writers, Html) {
  const std::string out = html_of(small().sections[0]);
  EXPECT_EQ(
      out,
      "<table>\n<caption>rows</caption>\n<thead><tr><th scope=\"col\">name</th>"
      "<th scope=\"col\" class=\"number\">value</th>"
      "<th scope=\"col\" class=\"number\">remark</th></tr></thead>\n<tbody>\n"
      "<tr><th scope=\"row\"><span class=\"word\">a</span></th>"
      "<td class=\"number\">1.2<span class=\"more\">[1.0,\u00a01.5]</span>"
      "<span class=\"more\">paper\u00a02.0</span></td>"
      "<td class=\"number\">λ\u00a0|\u00a050\u00a0%</td></tr>\n"
      "<tr><th scope=\"row\"><span class=\"word\">b</span><span class=\"more\">crashed</span>"
      "</th><td class=\"number\">—</td><td class=\"number\"></td></tr>\n</tbody>\n</table>\n");
}

TEST(Writers, RefuseARowThatDoesNotFillItsColumns) {
  Table table = small();
  table.sections[0].rows[1].pop_back();
  const std::function<std::string()> writers[] = {
      [&] { return markdown_of(table); }, [&] { return latex_of(table); },
      [&] { return csv_of(table.sections[0]); }, [&] { return html_of(table.sections[0]); },
      [&] { return terminal_of(table); }};
  for (const auto& write : writers) EXPECT_THROW(write(), std::invalid_argument);
}

}  // namespace
}  // namespace ertbench
