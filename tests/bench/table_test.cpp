// The table of results in its formats.

#include "bench/table/table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "bench/report/result_table.h"

namespace ertbench {
namespace {

ResultRow table_row(const std::string& label, const std::string& dataset) {
  ResultRow row;
  row.label = label;
  row.type = "one-step-gn";
  row.dataset = dataset;
  row.frames = 1000;
  for (const Metric metric : kMetrics) {
    row.metrics[metric] = {0.5, Interval{0.25, 0.75}, 0.5, 1000, 0};
  }
  row.metrics[Metric::AR] = {1.1017, Interval{1.0924, 1.1116}, 1.1, 1000, 0};
  row.metrics[Metric::RES] = {79.5, Interval{79.3, 79.7}, 79.4, 1000, 0};
  row.latency_us = LatencySummary{12.34, 45.61, 1234};
  row.frames_per_s = 98765;
  row.throughput_batch = 64;
  row.fit_s = 0.01234;
  return row;
}

ResultRow failed_row(const std::string& message) {
  ResultRow row;
  row.label = "dd-ert";
  row.type = "dd-ert";
  row.dataset = "test";
  row.status = "timed out";
  row.message = message;
  return row;
}

TableText text_of() {
  TableText text;
  text.title = "table_c1";
  text.dataset_descriptions["test"] = "one disc, 50 dB";
  text.command = "./ertbench run experiments/table_c1.json";
  text.published.source = "Zheng et al., Table C1";
  PublishedRow published;
  published.label = "gn";
  published.values[Metric::AR] = 1.231;
  published.values[Metric::RES] = 79.5;
  text.published.rows = {published};
  return text;
}

std::string markdown_table(std::span<const ResultRow> rows, const TableText& text) {
  return markdown_of(result_table(rows, text));
}

std::string latex_table(std::span<const ResultRow> rows, const TableText& text) {
  return latex_of(result_table(rows, text));
}

std::string csv_table(std::span<const ResultRow> rows, const PublishedTable& published) {
  return csv_of(result_data(rows, published));
}

std::vector<std::string> lines_with(const std::string& text, const std::string& start) {
  std::vector<std::string> found;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(start)) found.push_back(line);
  }
  return found;
}

/// Fields of all CSV records, read by RFC 4180.
std::vector<std::vector<std::string>> parsed(const std::string& csv) {
  std::vector<std::vector<std::string>> records(1, {""});
  bool quoted = false;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    const char c = csv[i];
    if (quoted && c == '"' && i + 1 < csv.size() && csv[i + 1] == '"') {
      records.back().back() += csv[++i];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      records.back().emplace_back();
    } else if (c == '\n' && !quoted) {
      records.push_back({""});
    } else {
      records.back().back() += c;
    }
  }
  records.pop_back();
  return records;
}

std::string field(const std::vector<std::vector<std::string>>& records, std::size_t record,
                  const std::string& column) {
  const auto& head = records.at(0);
  const auto at = std::find(head.begin(), head.end(), column);
  if (at == head.end()) return "no column " + column;
  return records.at(record).at(static_cast<std::size_t>(at - head.begin()));
}

TEST(ResultTable, ShowsThePipeWhereASolverHasOne) {
  std::vector<ResultRow> rows = {table_row("gn", "test"), table_row("python", "test")};
  EXPECT_EQ(markdown_table(rows, text_of()).find("pipe"), std::string::npos);
  rows[1].latency_us->pipe = 7.25;
  const std::string text = markdown_table(rows, text_of());
  EXPECT_NE(text.find("pipe (µs)"), std::string::npos) << text;
  EXPECT_NE(text.find("7.25"), std::string::npos) << text;
  EXPECT_NE(text.find("- pipe: of a solver that is a program of its own"), std::string::npos);
}

TEST(ResultTable, ShowsTheTimeToContactsWhereItWasMeasured) {
  std::vector<ResultRow> rows = {table_row("gn", "test"), table_row("older", "test")};
  EXPECT_EQ(markdown_table(rows, text_of()).find("to contacts"), std::string::npos);
  rows[0].latency_us->contacts_p50 = 14.5;
  rows[0].latency_us->contacts_p99 = 51.25;
  const std::string text = markdown_table(rows, text_of());
  EXPECT_NE(text.find("p99 (µs) | to contacts (µs) |"), std::string::npos) << text;
  EXPECT_NE(text.find(" 14.5 |"), std::string::npos) << text;
}

TEST(MarkdownTable, ShowsMeanIntervalPublishedValueAndDifference) {
  const std::vector<ResultRow> rows = {table_row("gn", "test")};
  const std::string out = markdown_table(rows, text_of());
  EXPECT_NE(out.find("1.102 [1.092, 1.112]<br>paper 1.231 (−0.129)"), std::string::npos) << out;
  EXPECT_NE(out.find("79.50 [79.30, 79.70]<br>paper 79.50 (0.00)"), std::string::npos) << out;
  EXPECT_NE(out.find("one disc, 50 dB; 1000 frames."), std::string::npos);
  EXPECT_NE(out.find("./ertbench run experiments/table_c1.json"), std::string::npos);
  EXPECT_NE(out.find("Zheng et al., Table C1"), std::string::npos);
  for (const char* number : {"12.3", "45.6", "98765", "0.0123"}) {
    EXPECT_NE(out.find(number), std::string::npos) << number;
  }
}

TEST(MarkdownTable, HasOneTableForEachDatasetAndAsManyCellsInEachLine) {
  std::vector<ResultRow> rows = {table_row("gn", "test"), table_row("a|b", "edge"),
                                 table_row("c", "test"), failed_row("a|b")};
  const std::string out = markdown_table(rows, text_of());
  EXPECT_EQ(lines_with(out, "## "), (std::vector<std::string>{"## test", "## edge"}));
  const auto lines = lines_with(out, "| ");
  EXPECT_EQ(lines.size(), 2 * 2 + rows.size());
  for (const std::string& line : lines) {
    std::size_t bars = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      bars += line[i] == '|' && (i == 0 || line[i - 1] != '\\') ? 1U : 0U;
    }
    const std::size_t columns = 1 + kMetrics.size() + 6;  // label, metrics, times, memory, counts
    EXPECT_EQ(bars, columns + 1) << line;
  }
}

TEST(MarkdownTable, ComparesWithThePaperOnItsDatasetsOnly) {
  TableText text = text_of();
  text.published.datasets = {"test"};
  const std::vector<ResultRow> rows = {table_row("gn", "edge")};
  EXPECT_EQ(markdown_table(rows, text).find("1.231"), std::string::npos);
  text.published.datasets = {"test", "edge"};
  EXPECT_NE(markdown_table(rows, text).find("1.231"), std::string::npos);
}

TEST(MarkdownTable, KeepsAFailedRowWithItsStatusAndMessage) {
  const std::string message = "line one\nline two " + std::string(200, 'x');
  const std::vector<ResultRow> rows = {table_row("gn", "test"), failed_row(message)};
  const std::string out = markdown_table(rows, text_of());
  const auto lines = lines_with(out, "| dd-ert<br>timed out: line one line two xxx");
  ASSERT_EQ(lines.size(), 1U) << out;
  EXPECT_NE(lines[0].find("…"), std::string::npos);
  EXPECT_NE(lines[0].find("—"), std::string::npos);
  EXPECT_EQ(lines[0].find("0.000"), std::string::npos) << "a failed row has no numbers";
  // The whole message stands below.
  EXPECT_NE(out.find("dd-ert, timed out: line one line two " + std::string(200, 'x')),
            std::string::npos);
}

TEST(MarkdownTable, ShowsUndefinedMetricsWithTheirCount) {
  ResultRow row = table_row("no-contact", "test");
  row.metrics[Metric::RES] = {std::nullopt, std::nullopt, std::nullopt, 0, 1000};
  row.metrics[Metric::PE] = {0.02, Interval{0.01, 0.03}, 0.02, 997, 3};
  const std::string out = markdown_table(std::vector{row}, text_of());
  EXPECT_NE(out.find("—<br>1000 undefined"), std::string::npos);
  EXPECT_NE(out.find("0.0200 [0.0100, 0.0300]<br>3 undefined"), std::string::npos);
}

/// A row of three seeds.
ResultRow seeded_row() {
  ResultRow row = table_row("net", "test");
  SeedSpread& seeds = row.seeds.emplace();
  seeds.values = {1, 2, 3};
  seeds.deviation[Metric::AR] = 0.0042;
  row.sweep = nlohmann::json{{"alpha", 0.001}};
  return row;
}

TEST(MarkdownTable, ShowsTheSpreadOfTheSeeds) {
  const std::string out = markdown_table(std::vector{seeded_row()}, text_of());
  EXPECT_NE(out.find("1.102 [1.092, 1.112]<br>± 0.004 over 3 seeds"), std::string::npos) << out;
  EXPECT_NE(out.find("standard deviation"), std::string::npos);
  EXPECT_NE(out.find("first seed's"), std::string::npos);
  const std::string single = markdown_table(std::vector{table_row("gn", "test")}, text_of());
  EXPECT_EQ(single.find("±"), std::string::npos);
}

TEST(MarkdownTable, LabelsStayWhatTheyAre) {
  const std::vector<ResultRow> rows = {
      table_row("*a* <b> [l](x) _e_ in_word `c` $m$ &amp;", "test")};
  const std::string out = markdown_table(rows, text_of());
  EXPECT_NE(out.find(R"(\*a\* &lt;b&gt; [l\](x) \_e\_ in_word \`c\` \$m\$ &amp;amp;)"),
            std::string::npos)
      << out;
}

TEST(MarkdownTable, NoRows) {
  EXPECT_NE(markdown_table({}, text_of()).find("table_c1"), std::string::npos);
  EXPECT_EQ(lines_with(markdown_table({}, text_of()), "| ").size(), 0U);
}

TEST(TerminalTable, HasASectionForEachDatasetAndALineForWhatWentWrong) {
  ResultRow undefined = seeded_row();
  undefined.undefined_frames = 3;
  const std::vector<ResultRow> rows = {table_row("gn", "test"), undefined, failed_row("no\nmemory"),
                                       table_row("gn", "edge")};
  const std::string out = terminal_of(result_summary(rows));
  // Numbers end where their titles end.
  const auto heads = lines_with(out, "solver");
  ASSERT_EQ(heads.size(), 2U) << out;
  const auto lines = lines_with(out, "gn");
  ASSERT_EQ(lines.size(), 2U) << out;
  EXPECT_EQ(heads[1].find("AR") + 2, lines[1].find("1.102") + 5) << out;
  EXPECT_EQ(heads[1].find("RES") + 7, lines[1].find("79.50") + 5) << out;
  EXPECT_NE(lines[0].find("98765  ok"), std::string::npos) << out;
  EXPECT_NE(out.find("ok, 3 undefined\n"), std::string::npos) << out;
  EXPECT_NE(out.find("±0.004"), std::string::npos) << out;
  EXPECT_NE(out.find("over 3 seeds\n"), std::string::npos) << out;
  EXPECT_NE(out.find("dd-ert, timed out: no memory\n"), std::string::npos) << out;
  EXPECT_LT(out.find("dd-ert, timed out"), out.find("\nedge\n")) << "below its own test set";
  for (const Metric metric : kHeadlineMetrics) {
    EXPECT_NE(heads[0].find(entry_of(metric).heading), std::string::npos);
  }
}

TEST(CsvTable, EveryNumberHasAColumn) {
  const std::vector<ResultRow> rows = {table_row("gn", "test"), failed_row("a, \"b\"\nc")};
  const auto records = parsed(csv_table(rows, text_of().published));
  ASSERT_EQ(records.size(), 3U);
  for (const auto& record : records) EXPECT_EQ(record.size(), records[0].size());
  EXPECT_EQ(field(records, 1, "label"), "gn");
  EXPECT_EQ(field(records, 1, "AR_mean"), "1.1017");
  EXPECT_EQ(field(records, 1, "AR_low"), "1.0924");
  EXPECT_EQ(field(records, 1, "AR_high"), "1.1116");
  EXPECT_EQ(field(records, 1, "AR_median"), "1.1");
  EXPECT_EQ(field(records, 1, "AR_paper"), "1.231");
  EXPECT_NEAR(std::stod(field(records, 1, "AR_difference")), 1.1017 - 1.231, 1e-15);
  EXPECT_EQ(field(records, 1, "AR_undefined"), "0");
  EXPECT_EQ(field(records, 1, "PE_paper"), "");
  EXPECT_EQ(field(records, 1, "latency_p99_us"), "45.61");
  EXPECT_EQ(field(records, 1, "fit_s"), "0.01234");
  EXPECT_EQ(field(records, 1, "parameters"), "{}");
}

TEST(CsvTable, QuotesTextAndLeavesWhatIsUndefinedEmpty) {
  const std::vector<ResultRow> rows = {failed_row("a, \"b\"\nc")};
  const std::string csv = csv_table(rows, {});
  EXPECT_NE(csv.find("\"a, \"\"b\"\"\nc\""), std::string::npos);
  const auto records = parsed(csv);
  EXPECT_EQ(field(records, 1, "message"), "a, \"b\"\nc");
  EXPECT_EQ(field(records, 1, "status"), "timed out");
  EXPECT_EQ(field(records, 1, "AR_mean"), "");
  EXPECT_EQ(field(records, 1, "latency_p50_us"), "");
  EXPECT_EQ(csv.find("nan"), std::string::npos);
}

TEST(CsvTable, HoldsTheSpreadOfTheSeedsAndTheSweep) {
  const auto records =
      parsed(csv_table(std::vector{seeded_row(), table_row("gn", "test")}, text_of().published));
  EXPECT_EQ(field(records, 1, "seeds"), "1 2 3");
  EXPECT_EQ(field(records, 1, "AR_seed_deviation"), "0.0042");
  EXPECT_EQ(field(records, 1, "PE_seed_deviation"), "");
  EXPECT_EQ(field(records, 1, "sweep"), R"({"alpha":0.001})");
  EXPECT_EQ(field(records, 2, "seeds"), "");
}

TEST(LatexTable, ShowsTheSpreadOfTheSeeds) {
  const std::string out = latex_table(std::vector{seeded_row()}, text_of());
  EXPECT_NE(out.find("\\ensuremath{\\pm} 0.004"), std::string::npos) << out;
}

TEST(LatexTable, EscapesWhatLatexWouldTakeForItsOwn) {
  const std::vector<ResultRow> rows = {table_row("a_b&c%d#e$f{g}h~i^j\\k--l", "test")};
  const std::string out = latex_table(rows, {});
  EXPECT_EQ(out.find("a_b"), std::string::npos);
  std::string label;  // without the line breaks of the narrow column
  for (std::size_t i = out.find("a\\_"); i < out.find("1.102"); ++i) label += out[i];
  for (const char* part : {"a\\_", "b\\&c", "\\%d", "\\#e", "\\$f", "\\{g", "\\}h",
                           "\\textasciitilde{}", "\\textasciicircum{}", "\\textbackslash{}"}) {
    EXPECT_NE(label.find(part), std::string::npos) << part << " in " << label;
  }
  EXPECT_EQ(label.find("--"), std::string::npos);
}

TEST(LatexTable, IsBalancedAndPureAsciiButForLatinLetters) {
  const std::vector<ResultRow> rows = {table_row("λ → é ₀ 漢", "test"),
                                       failed_row("[a] 50 %\n& more"), table_row("gn", "edge")};
  const std::string out = latex_table(rows, text_of());
  const auto count = [&](const std::string& word) {
    std::size_t n = 0;
    for (auto at = out.find(word); at != std::string::npos; at = out.find(word, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("\\begin{table}"), 2U);
  EXPECT_EQ(count("\\begin{"), count("\\end{"));
  EXPECT_EQ(count("{"), count("}"));  // no brace of a label's here
  EXPECT_NE(out.find("\\ensuremath{\\lambda} [U+2192] é \\ensuremath{_0}"), std::string::npos);
  EXPECT_EQ(out.find("\\\\["), std::string::npos) << "an interval read as the option of a line end";
  EXPECT_NE(out.find("[U+6F22]"), std::string::npos);
  EXPECT_NE(out.find("50 \\%"), std::string::npos);
  EXPECT_NE(out.find("paper 1.231"), std::string::npos);
  EXPECT_NE(out.find("(\\ensuremath{-}0.129)"), std::string::npos);
  std::size_t outside = 0;  // bytes of characters beyond ASCII: the two of "é", in three parts
  for (const char c : out) outside += static_cast<unsigned char>(c) >= 0x80 ? 1U : 0U;
  EXPECT_EQ(outside, 6U);
}

}  // namespace
}  // namespace ertbench
