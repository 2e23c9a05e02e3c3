// Text from outside, a plugin's or an experiment's, on its way into every form in which the program
// shows it. The input is one text, or several with a zero byte between two, which take turns.

#include <array>
#include <cctype>

#include "bench/plot/canvas.h"
#include "bench/record/record_file.h"
#include "bench/report/report.h"
#include "bench/report/result_table.h"
#include "bench/table/table.h"
#include "core/json.h"
#include "core/text.h"
#include "tests/fuzz/fuzz_input.h"

namespace ertbench {
namespace {

using fuzzing::folder;
using fuzzing::require;
using fuzzing::require_plain_text;
using nlohmann::json;

/// The texts of the input, in turn.
class Texts {
 public:
  explicit Texts(std::string_view input) : texts_(split(input, std::string_view("\0", 1))) {}
  const std::string& next() { return texts_[taken_++ % texts_.size()]; }

 private:
  std::vector<std::string> texts_;
  std::size_t taken_ = 0;
};

/// A row as a trial writes it and the run reads it.
ResultRow row_of(Texts& texts) {
  ResultRow row;
  row.label = row.type = "plugin";
  row.dataset = "test";
  row.status = "failed";
  row.message = texts.next();
  row.parameters = json{{"name", texts.next()}, {texts.next(), 1}};
  const std::filesystem::path file = folder() / "record.json";
  write_record(file, {{"row", to_json(row)}}, "", {});
  const json record = read_json_file(file);
  return result_row_from_json(JsonObject(record.at("row"), file.string(), "/row"));
}

void check_csv(const TableSection& section) {
  const std::string text = csv_of(section);
  require_plain_text(text, "CSV");
  const auto lines = csv_lines(text);
  require(lines.size() == 1 + section.rows.size(), "a row of CSV is not a line", text);
  for (const std::vector<std::string>& line : lines) {
    require(line.size() == section.columns.size(), "a line of CSV has other columns", text);
    for (const std::string& cell : line) {
      char* end = nullptr;
      std::strtod(cell.c_str(), &end);
      const bool number = !cell.empty() && *end == '\0';
      require(number || cell.find_first_of("=+-@\t\r") != 0, "a spreadsheet runs this cell", cell);
    }
  }
}

/// Bars that divide columns: those without a backslash before them.
std::size_t bars(const std::string& line) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\\') {
      ++i;
    } else {
      count += line[i] == '|';
    }
  }
  return count;
}

void check_markdown(const Table& table) {
  const std::string text = markdown_of(table);
  require_plain_text(text, "Markdown");
  const std::string line_break = "<br>";
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    require(text.compare(at, line_break.size(), line_break) == 0, "HTML in Markdown", text);
  }
  std::size_t rows = 0;
  for (const std::string& line : split(text, "\n")) {
    if (!line.starts_with("| ")) continue;
    ++rows;
    require(bars(line) == 1 + table.sections.front().columns.size(), "a row has other columns",
            line);
  }
  require(rows == 2 + table.sections.front().rows.size(), "a row of Markdown is not a line", text);
}

void check_latex(const Table& table) {
  const std::string text = latex_of(table);
  require_plain_text(text, "LaTeX");
  int open = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\\') {
      ++i;
    } else {
      open += (text[i] == '{') - (text[i] == '}');
    }
    require(open >= 0, "a brace of LaTeX closes nothing", text);
  }
  require(open == 0, "a brace of LaTeX stays open", text);
}

/// Every "<" begins a tag of ours, whose quotation marks are closed.
void check_markup(const std::string& text) {
  constexpr std::array ours = {"!DOCTYPE", "html", "head",    "meta",    "title",   "style", "body",
                               "main",     "h1",   "h2",      "p",       "nav",     "ul",    "li",
                               "a",        "div",  "table",   "caption", "thead",   "tbody", "tr",
                               "th",       "td",   "span",    "section", "pre",     "code",  "svg",
                               "g",        "rect", "details", "b",       "summary", "figure"};
  std::size_t scripts = 0;
  for (auto at = text.find('<'); at != std::string::npos; at = text.find('<', at + 1)) {
    const std::size_t begin = at + (text.compare(at, 2, "</") == 0 ? 2 : 1);
    std::size_t end = begin;
    while (end < text.size() &&
           (std::isalnum(static_cast<unsigned char>(text[end])) || text[end] == '!')) {
      ++end;
    }
    const std::string name = text.substr(begin, end - begin);
    scripts += name == "script" && begin == at + 1;
    const bool known = std::find(ours.begin(), ours.end(), name) != ours.end();
    require(known || name == "script", "a tag that is not ours", text.substr(at, 100));
    const std::string tag = text.substr(at, text.find('>', at) - at);
    require(std::count(tag.begin(), tag.end(), '"') % 2 == 0, "an open quotation mark", tag);
  }
  require(scripts <= 1, "a script that is not ours", text);
  require_plain_text(text, "HTML");
}

void check_gnuplot(const std::string& text) {
  const std::string quoted = gnuplot_string(text);
  require_plain_text(quoted, "a string of gnuplot's");
  require(quoted.size() >= 2 && quoted.front() == '"' && quoted.back() == '"', "not quoted",
          quoted);
  for (std::size_t i = 1; i + 1 < quoted.size(); ++i) {
    require(quoted[i] != '"' && quoted[i] != '`' && quoted[i] != '\n', "text leaves its string",
            quoted);
    if (quoted[i] != '\\') continue;
    const bool octal = quoted.find_first_not_of("01234567", i + 1) >= i + 4;
    require(octal, "a backslash that is no octal number", quoted);
    i += 3;
  }
}

void check_lines(const std::string& text) {
  constexpr std::size_t width = 20;
  require(character_count(one_line(text, width)) <= width + 1, "a line is too long", text);
  for (const std::string& line : wrapped(text, width)) {
    require(character_count(line) <= width, "a wrapped line is too long", line);
  }
}

Report report_of(const Table& table, Texts& texts) {
  Report report;
  report.title = texts.next();
  report.question = texts.next();
  ReportSection& section = report.sections.emplace_back();
  section.title = texts.next();
  section.text = texts.next();
  section.tables = table.sections;
  section.notes = {texts.next()};
  section.code = texts.next();
  return report;
}

}  // namespace
}  // namespace ertbench

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ertbench;
  Texts texts({reinterpret_cast<const char*>(bytes), size});
  const std::vector<ResultRow> rows = {row_of(texts), row_of(texts)};
  TableText around;
  around.title = texts.next();
  around.dataset_descriptions["test"] = texts.next();
  const Table table = result_table(rows, around);
  check_csv(result_data(rows, {}));
  check_markdown(table);
  check_latex(table);
  require_plain_text(terminal_of(table), "the terminal's table");
  require_plain_text(terminal_of(result_summary(rows)), "the terminal's summary");
  check_markup(report_html(report_of(table, texts)));
  check_markup(with_tooltips("<svg></svg>", {{{0, 0, 1, 1}, texts.next()}}));
  check_gnuplot(texts.next());
  check_lines(texts.next());
  return 0;
}
