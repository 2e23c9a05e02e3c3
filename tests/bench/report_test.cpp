#include "bench/report/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>

#include "bench/plot/canvas.h"
#include "bench/report/heat_map.h"
#include "bench/run/results.h"
#include "core/errors.h"
#include "core/text.h"
#include "tests/bench/figure_testing.h"
#include "tests/bench/markup.h"

namespace ertbench {
namespace {

using testing::attribute_values;
using testing::count;
using testing::markup_error;

const std::string hostile = "<script>alert(\"x\")</script> & 'q' ]]> -- δσ";
const std::string harmless =
    "&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt; &amp; &#39;q&#39; ]]&gt; -- δσ";

TEST(HtmlEscaped, LeavesNoMarkup) { EXPECT_EQ(html_escaped(hostile), harmless); }

TEST(HtmlEscaped, IsUtf8WithoutControlCharacters) {
  EXPECT_EQ(html_escaped("a\tb\nc\x01\x7f\r\x1b[0m"), "a\tb\nc[0m");
  EXPECT_EQ(html_escaped("µ \xff \xe2\x82 €"), "µ \ufffd \ufffd €");
  EXPECT_EQ(html_escaped("\xe0\x80\xbc"), "\ufffd") << "an overlong < is none";
  EXPECT_EQ(html_escaped("a\xc2\x9b\u202e\uffff"), "a");
  EXPECT_EQ(html_escaped("\xed\xa0\x80"), "\ufffd") << "half of a pair";
  EXPECT_EQ(html_escaped("😀"), "😀");
}

TEST(InlineSvg, IdsAreItsOwn) {
  const std::string svg =
      "<?xml version=\"1.0\"?>\n<svg width='9'><defs><path id='a'/><path id=\"b\"/></defs>"
      "<use xlink:href='#a' id='c'/><g clip-path=\"url(#b)\" data-x='1>0'>"
      "<text>id='a' url(#b) href='#a'</text></g></svg>\n";
  EXPECT_EQ(inline_svg(svg, "f1-", "A \"chart\""),
            "<svg role=\"img\" aria-label=\"A &quot;chart&quot;\" width='9'><defs>"
            "<path id='f1-a'/><path id=\"f1-b\"/></defs><use xlink:href='#f1-a' />"
            "<g clip-path=\"url(#f1-b)\" data-x='1>0'>"
            "<text>id='a' url(#b) href='#a'</text></g></svg>");
}

TEST(InlineSvg, RefusesWhatRefersToOtherFiles) {
  EXPECT_THROW(inline_svg("<svg><image href=\"a.png\"/></svg>", "", ""), std::invalid_argument);
  EXPECT_THROW(inline_svg("<svg><use xlink:href='http://a/b#c'/></svg>", "", ""),
               std::invalid_argument);
  EXPECT_NO_THROW(inline_svg("<svg><image href='data:image/png;base64,AA=='/></svg>", "", ""));
}

TEST(InlineSvg, RefusesWhatIsNoPicture) {
  for (const char* text : {"", "<p>no picture</p>", "<svg><g a='1></svg>", "<svg><g '1'/></svg>",
                           "<svg><g a='1' '2'/></svg>"}) {
    EXPECT_THROW(inline_svg(text, "", ""), std::invalid_argument) << text;
  }
}

TEST(SvgTooltips, StandAboveAllThatIsDrawn) {
  EXPECT_EQ(with_tooltips("<svg><g/></svg>\n", {}), "<svg><g/></svg>\n");
  EXPECT_EQ(
      with_tooltips("<svg><g/></svg>\n", {{{1, 2.5, 4, 6.5}, "a <b>\nc"}}),
      "<svg><g/><g class=\"tooltips\" fill=\"none\" pointer-events=\"all\">\n"
      "<rect x=\"1\" y=\"2.5\" width=\"3\" height=\"4\"><title>a &lt;b&gt;\nc</title></rect>\n"
      "</g>\n</svg>\n");
  EXPECT_THROW(with_tooltips("", {{{0, 0, 1, 1}, "a"}}), std::invalid_argument);
}

class ReportPage : public testing::FigureTest {
 protected:
  /// A chart of one cell.
  ReportFigure figure(const std::string& name) const {
    HeatMap map;
    map.title = map.x_name = map.y_name = hostile;
    map.x_values = map.y_values = {"1"};
    map.statuses = {""};
    map.panels = {{"AR", "|AR − 1|", 3, {1.1}, {0.1}}};
    draw_heat_map(map, results() / name);
    return {name, results() / (name + ".svg"), hostile};
  }
};

/// Neither a file beside the page nor an address, but for the names of the SVG's languages.
void expect_self_contained(const std::string& html) {
  for (const char* name : {"src", "href", "xlink:href", "data", "action", "srcset", "poster"}) {
    for (const std::string& value : attribute_values(html, name)) {
      EXPECT_TRUE(value.starts_with("#") || value.starts_with("data:")) << name << "=" << value;
    }
  }
  EXPECT_EQ(count(html, "://"), attribute_values(html, "xmlns[:a-z]*").size());
  EXPECT_EQ(count(html, "@import"), 0U);
  EXPECT_EQ(count(html, "url("), count(html, "url(#"));
  EXPECT_NE(html.find("default-src 'none'"), std::string::npos);
}

TEST_F(ReportPage, NeedsNothingBesideIt) {
  Report report;
  report.title = report.question = hostile;
  ReportSection section;
  section.title = section.text = section.code = hostile;
  section.notes = {hostile};
  TableSection table;
  table.caption = hostile;
  table.columns = {{hostile, Align::left}, "p50 (µs)"};
  Cell time = number_cell(1.5, 1);
  time.interval = hostile;
  time.lines = {hostile};
  table.rows = {{hostile, time}};
  section.tables = {table};
  section.figures = {figure("one"), figure("two"), figure("three")};
  report.sections = {section, section};
  report.sections[1].collapsed = true;
  const std::string html = report_html(report);
  EXPECT_EQ(markup_error(html), "");
  expect_self_contained(html);
  EXPECT_EQ(count(html, "<script"), 1U) << "our own, for printing";
  EXPECT_GT(count(html, harmless), 10U);
  EXPECT_EQ(count(html, "<svg "), 6U);
  EXPECT_EQ(count(html, "<title>1.100"), 0U);
  EXPECT_EQ(count(html, "\nAR: 1.100; |AR − 1|: 0.100</title>"), 6U);
  EXPECT_EQ(count(html, "<details>"), 1U);

  const std::vector<std::string> ids = attribute_values(html, "id");
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size());
  EXPECT_GT(ids.size(), 6U);
  for (const std::string& link : attribute_values(html, "(?:xlink:)?href")) {
    if (!link.starts_with("#")) continue;
    EXPECT_NE(std::find(ids.begin(), ids.end(), link.substr(1)), ids.end()) << link;
  }
}

TEST_F(ReportPage, TablesSayWhatTheirCellsAre) {
  Report report;
  report.sections.resize(1);
  TableSection& table = report.sections[0].tables.emplace_back();
  table.caption = "Speeds";
  table.columns = {{"solver", Align::left}, "time", {"remark", Align::left}};
  Cell failed = "gn";
  failed.lines = {"failed"};
  Cell time = "2 µs";
  time.interval = "[1, 3]";
  time.lines = {"±1 over 3"};
  table.rows = {{failed, "—", "none"}, {"b c", time, "x [y]"}};
  const std::string html = report_html(report);
  EXPECT_NE(html.find("<caption>Speeds</caption>"), std::string::npos);
  EXPECT_NE(html.find("<th scope=\"col\">solver</th><th scope=\"col\" class=\"number\">time</th>"
                      "<th scope=\"col\">remark</th>"),
            std::string::npos);
  EXPECT_NE(html.find("<span class=\"word\">gn</span><span class=\"more\">failed</span></th>"
                      "<td class=\"number\">—</td><td>none</td>"),
            std::string::npos);
  EXPECT_NE(html.find("<td class=\"number\">2\u00a0µs<span class=\"more\">[1,\u00a03]</span><span "
                      "class=\"more\">±1 over\u00a03</span></td><td>x [y]</td>"),
            std::string::npos);
  report.sections[0].tables[0].rows[1].pop_back();
  EXPECT_THROW(report_html(report), std::invalid_argument);
}

TEST_F(ReportPage, NamesAChartThatIsNotThere) {
  Report report;
  report.sections.resize(1);
  report.sections[0].figures = {{"a", results() / "absent.svg", ""}};
  try {
    report_html(report);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("absent.svg"), std::string::npos) << error.what();
  }
}

ResultRow reported_row(const std::string& label, const std::string& dataset) {
  ResultRow row;
  row.label = row.type = label;
  row.dataset = dataset;
  row.frames = 1000;
  for (const Metric metric : kMetrics) {
    row.metrics[metric] = {0.5, Interval{0.25, 0.75}, 0.5, 1000, 0};
  }
  row.latency_us = LatencySummary{12.34, 45.61, 1234};
  row.frames_per_s = 98765;
  row.fit_s = 0.01234;
  row.peak_rss_mb = 456.7;
  return row;
}

TEST_F(ReportPage, OfAnExperimentKeepsEveryRowWithItsNumbers) {
  Experiment experiment;
  experiment.title = "A comparison";
  experiment.question = "Which is best?";
  experiment.tests.resize(2);
  experiment.tests[0].name = "test";
  experiment.tests[1].name = "edge";
  TableText text;
  text.command = "./ertbench run 'a & b.json'";
  text.published.source = "Zheng et al., Table C1";
  text.published.rows = {{"gn", {}}};
  text.published.rows[0].values[Metric::AR] = 1.231;
  std::vector<ResultRow> rows = {reported_row("truth", "test"), reported_row("no-contact", "test"),
                                 reported_row("gn", "test"),    reported_row("net", "test"),
                                 reported_row("lost", "test"),  reported_row("gn", "edge")};
  rows[3].seeds = SeedSpread{};
  rows[3].seeds->values = {1, 2, 3};
  rows[3].seeds->deviation[Metric::AR] = 0.004;
  rows[4] = ResultRow{};
  rows[4].label = "lost";
  rows[4].dataset = "test";
  rows[4].status = "timed out";
  rows[4].message = "after 60 s " + std::string(200, 'x');
  const nlohmann::json provenance = {{"commit", "abc123"},
                                     {"libraries", {{"eigen", "3.4.0"}}},
                                     {"seeds", {{"test", 3}, {"edge", 4}}},
                                     {"datasets", {{"test", {{"snr_db", 50}}}}}};
  const std::string html =
      report_html(report_of(experiment, rows, text, {}, {}, provenance, results()));
  EXPECT_EQ(markup_error(html), "");
  expect_self_contained(html);
  EXPECT_EQ(count(html, "<tr><th scope=\"row\">"), rows.size() + 4) << "and the provenance";
  for (const char* words :
       {"A comparison", "Which is best?", "0.500<span class=\"more\">[0.250,\u00a00.750]</span>",
        "paper\u00a01.231 (−0.731)", "±\u00a00.004 over\u00a03\u00a0seeds", ">12.3<", ">45.6<",
        ">98765<", ">0.0123<", ">457<", "timed out: after 60 s", "abc123", "eigen 3.4.0",
        "edge 4, test 3", "net: 1, 2, 3", "&quot;snr_db&quot;: 50",
        "./ertbench run &#39;a &amp; b.json&#39;"}) {
    EXPECT_NE(html.find(words), std::string::npos) << words;
  }
  EXPECT_NE(html.find(std::string(200, 'x')), std::string::npos) << "the whole message, below";
}

}  // namespace
}  // namespace ertbench
