// Texts that anybody may have put into a label, a message or a file's name, through every writer.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/pages/page.h"
#include "bench/plot/canvas.h"
#include "bench/report/report.h"
#include "bench/table/table.h"
#include "core/process.h"
#include "core/text.h"
#include "tests/bench/figure_testing.h"
#include "tests/bench/markup.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using Hostile = testing::FigureTest;

const std::vector<std::string> hostile_texts = {
    "<script>alert(1)</script>",
    "]]><script>alert(1)</script><![CDATA[",
    "<img src=x onerror=alert(1)>",
    "\x1b[2J\x1b[31mred",
    "\x1b]0;title\x07",
    "\xc2\x9b\x33\x31mred",
    "bell\x07 back\b delete\x7f nul" + std::string(1, '\0') + " end",
    "left \u202e right \u2066 isolated",
    "bytes \xff\xfe, half \xe2\x82, overlong \xe0\x80\xbc",
    "no character \ufffe",
    "=HYPERLINK(\"http://x\")",
    "@SUM(1)",
    "-1+cmd|' /C calc'!A0",
    "\t=1",
    "two\r\nlines\tand a tab",
    "`touch x` $(touch x) \"; set output 'x'; # \\",
    "50 % of %s %n",
    "[a](javascript:alert(1)) ![b](http://x)",
    "</title></text></svg><script>alert(1)</script>",
};

struct Writer {
  const char* name;
  bool markup;  ///< of whoever reads it "<" begins a tag
  std::function<std::string(const std::string& text)> write;
};

Table table_of(const std::string& text) {
  Table table;
  table.title = table.text = table.command = text;
  table.legend = {text};
  TableSection& section = table.sections.emplace_back();
  section.caption = section.text = text;
  section.columns = {{text, Align::left}, text};
  Cell cell = text;
  cell.interval = text;
  cell.lines = {text};
  section.rows = {{cell, cell}};
  section.notes = {text};
  return table;
}

std::string report_of_text(const std::string& text) {
  Report report;
  report.title = report.question = text;
  ReportSection& section = report.sections.emplace_back();
  section.title = section.text = section.code = text;
  section.notes = {text};
  section.tables = table_of(text).sections;
  return report_html(report);
}

/// A page that shows a label of a CSV file and of a summary.json.
std::string page_of_text(const std::string& text) {
  const testing::TemporaryFolder folder("page");
  testing::write_text(folder / "t.csv",
                      "label,RIE\n" + csv_field(text) + ",1\n" + csv_field("b") + ",2\n");
  std::filesystem::create_directories(folder / "s");
  const nlohmann::json rows = {{{"label", printable(text)}, {"x", 1}}};
  testing::write_text(folder / "s/summary.json", nlohmann::json{{"rows", rows}}.dump());
  return render_page(
      "{{each t.csv *: | {label} | {.1f RIE} |}}\n{{(best (t.csv * RIE))}}\n"
      "{{each s *: | {label} |}}\n",
      "page.md.in", folder.path());
}

std::string progress_of(const std::string& text) {
  ::testing::internal::CaptureStderr();
  Progress(text).update(1, 1, text);
  return ::testing::internal::GetCapturedStderr();
}

/// Without the command, which stands in a block of code, where nothing is markup.
std::string before_the_fence(const std::string& text) {
  const std::string out = markdown_of(table_of(text));
  return out.substr(0, out.find("\n```"));
}

const std::vector<Writer> writers = {
    {"Markdown", true, before_the_fence},
    {"command", false, [](const auto& text) { return markdown_of(table_of(text)); }},
    {"LaTeX", true, [](const auto& text) { return latex_of(table_of(text)); }},
    {"HTML", true, [](const auto& text) { return html_of(table_of(text).sections[0]); }},
    {"CSV", false, [](const auto& text) { return csv_of(table_of(text).sections[0]); }},
    {"terminal", false, [](const auto& text) { return terminal_of(table_of(text)); }},
    {"progress", false, progress_of},
    {"page", true, page_of_text},
    {"gnuplot", false, gnuplot_string},
    {"tooltips", true,
     [](const auto& text) {
       return with_tooltips("<svg></svg>", {{{}, text}});
     }},
    {"inlined SVG", true, [](const auto& text) { return inline_svg("<svg></svg>", "a", text); }},
    {"message", false, [](const auto& text) { return printable(text); }},
};

/// A tab is white space for everybody who reads these formats.
bool has_control(const std::string& text) {
  const std::vector<char32_t> points = code_points(text);
  return std::any_of(points.begin(), points.end(), [](char32_t point) {
    return point != U'\n' && point != U'\t' && is_control(point);
  });
}

bool is_utf8(const std::string& text) {
  std::string again;
  for (const char32_t point : code_points(text)) append_utf8(again, point);
  return again == text;
}

TEST_F(Hostile, TextReachesNoReaderAsAnythingElse) {
  for (const Writer& writer : writers) {
    for (const std::string& text : hostile_texts) {
      const std::string out = writer.write(text);
      SCOPED_TRACE(std::string(writer.name) + ": " + out);
      EXPECT_TRUE(is_utf8(out));
      EXPECT_FALSE(has_control(out));
      if (!writer.markup) continue;
      EXPECT_EQ(out.find("<script"), std::string::npos);
      EXPECT_EQ(out.find("<img"), std::string::npos);
    }
  }
}

TEST_F(Hostile, TextOpensNoLinkInMarkdown) {
  const std::string out = page_of_text("[a](javascript:alert(1))");
  EXPECT_EQ(out.find("[a](javascript"), std::string::npos) << out;
}

TEST_F(Hostile, CellsAreNoFormulas) {
  for (const std::string& text : hostile_texts) {
    for (const auto& line : csv_lines(csv_of(table_of(text).sections[0]))) {
      EXPECT_EQ(line.size(), 2U) << text;
    }
    const std::string cell = csv_of(table_of(text).sections[0]);
    const std::size_t first = cell.find_first_not_of("\" ");
    EXPECT_EQ(std::string("=+-@\t\r").find(cell[first]), std::string::npos) << cell;
  }
}

TEST_F(Hostile, ReportIsWellFormed) {
  for (const std::string& text : hostile_texts) {
    const std::string html = report_of_text(text);
    const std::string body = html.substr(html.find("<body>"));
    EXPECT_FALSE(has_control(html)) << text;
    EXPECT_EQ(body.find("<script>alert"), std::string::npos) << text;
  }
}

TEST_F(Hostile, ChartsAreWellFormedPictures) {
  Canvas canvas(400, 30.0 * static_cast<double>(hostile_texts.size()) + 60);
  canvas.title(hostile_texts[0]);
  double y = 40;
  for (const std::string& text : hostile_texts) {
    canvas.text(text, 200, y);
    canvas.tooltip_at(200, y, text);
    y += 30;
  }
  canvas.draw(results() / "chart");
  EXPECT_EQ(files(), (std::set<std::string>{"chart.png", "chart.svg"}));
  const std::string svg = read("chart.svg");
  EXPECT_TRUE(is_utf8(svg));
  EXPECT_EQ(svg.find("<script"), std::string::npos);
  EXPECT_EQ(svg.find("]]>"), std::string::npos);
  EXPECT_EQ(testing::markup_error(svg.substr(svg.find("<svg"))), "");
  EXPECT_NE(svg.find("50 % of %s %n"), std::string::npos);
  EXPECT_EQ(inline_svg(svg, "f1-", "chart").find("<script"), std::string::npos);
}

}  // namespace
}  // namespace ertbench
