#include "bench/pages/page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "bench/pages/page_expression.h"
#include "core/errors.h"
#include "core/text.h"
#include "tests/bench/program.h"

namespace ertbench {
namespace {

using testing::TemporaryFolder;

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \n") - first + 1);
}

std::size_t line_at(const std::string& text, std::size_t at) {
  return 1 + static_cast<std::size_t>(
                 std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// Blanks out what matches, line ends kept.
void blank_out(std::string& text, const std::regex& what) {
  std::string out;
  auto from = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), what), end; match != end; ++match) {
    out.append(from, (*match)[0].first);
    for (auto c = (*match)[0].first; c != (*match)[0].second; ++c) out += *c == '\n' ? '\n' : ' ';
    from = (*match)[0].second;
  }
  text = out.append(from, text.cend());
}

/// Phrases of the comments "constants: a; b", the longest first.
std::vector<std::string> constants_of(const std::string& text) {
  static const std::regex comment("<!-- constants:([^>]*)-->");
  std::vector<std::string> out;
  for (std::sregex_iterator match(text.begin(), text.end(), comment), end; match != end; ++match) {
    for (const std::string& phrase : split((*match)[1].str(), ";")) {
      if (!trimmed(phrase).empty()) out.push_back(trimmed(phrase));
    }
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

bool is_part_of_number(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '.'; }

/// Blanks out a phrase wherever it stands as a whole.
void blank_out(std::string& text, const std::string& phrase) {
  for (std::size_t at = 0; (at = text.find(phrase, at)) != std::string::npos;) {
    const std::size_t after = at + phrase.size();
    const bool begins = at == 0 || !is_part_of_number(text[at - 1]);
    const bool ends =
        after >= text.size() || !std::isalnum(static_cast<unsigned char>(text[after]));
    const bool decimals = after + 1 < text.size() && text[after] == '.' &&
                          std::isdigit(static_cast<unsigned char>(text[after + 1]));
    if (begins && ends && !decimals) text.replace(at, phrase.size(), phrase.size(), ' ');
    at = after;
  }
}

/// Words with digits that stand literally in a page's source, "line 12: 0.714": outside of braces,
/// code, links and comments, and not among the constants that the page declares in a comment,
///
///     <!-- constants: 24 x 24; 95 %; [-1, 1] -->
///
/// Words that begin with a letter (HDF5, C.3) are names.
std::vector<std::string> literal_numbers(const std::string& text) {
  std::string rest = text;
  const std::vector<std::string> constants = constants_of(text);
  static const std::regex left_out[] = {
      std::regex("```[^`]*```"), std::regex("\\{\\{([^}]|\\}[^}])*\\}+"), std::regex("`[^`]*`"),
      std::regex("<!--([^-]|-[^-]|--[^>])*-->"), std::regex("\\]\\([^)\\s]*\\)")};
  for (const std::regex& what : left_out) blank_out(rest, what);
  for (const std::string& phrase : constants) blank_out(rest, phrase);
  std::vector<std::string> out;
  static const std::regex word("[A-Za-z0-9_.-]*[0-9][A-Za-z0-9_.%-]*");
  for (std::sregex_iterator match(rest.begin(), rest.end(), word), end; match != end; ++match) {
    const std::string found = (*match)[0].str();
    if (std::isalpha(static_cast<unsigned char>(found.front()))) continue;
    out.push_back("line " +
                  std::to_string(line_at(rest, static_cast<std::size_t>(match->position()))) +
                  ": " + found);
  }
  return out;
}

class PageTest : public ::testing::Test {
 protected:
  PageTest() {
    std::filesystem::create_directories(folder_ / "t");
    testing::write_text(folder_.path() / "t/summary.json", R"({"rows": [
        {"label": "gn", "type": "gn", "metrics": {"RIE": {"mean": 0.05, "ci95": [0.04, 0.06]}},
         "latency_us": {"p50": 3.9}, "seeds": null},
        {"label": "net a", "type": "net", "metrics": {"RIE": {"mean": 0.025, "ci95": [0.02, 0.03]}},
         "latency_us": {"p50": 620.0}, "seeds": {"deviation": {"RIE": 0.001}}},
        {"label": "net b", "type": "net", "metrics": {"RIE": {"mean": 0.03, "ci95": [0.02, 0.04]}},
         "latency_us": {"p50": 1200.0}}]})");
    testing::write_text(folder_.path() / "t/levels.csv",
                        "solver,axis,share\ngn,snr,0.1\ngn,dead,1\nnet,snr,0.02\n");
  }

  std::string render(const std::string& text) const {
    return render_page(text, "page.md.in", folder_.path());
  }

  std::string error(const std::string& text) const {
    try {
      render(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_{"page"};
};

TEST_F(PageTest, ValuesStandWhereTheyAreReferredTo) {
  EXPECT_EQ(render("RIE {{.3f t gn RIE}}."), "RIE 0.050.");
  EXPECT_EQ(render("{{.2f t 'net a' RIE.ci95.0}}"), "0.02");
  EXPECT_EQ(render("{{us t gn latency_us.p50}}, {{us t 'net a' latency_us.p50}}"),
            "3.9 µs, 0.62 ms");
  EXPECT_EQ(render("{{.0% t/levels.csv solver=gn,axis=dead share}}"), "100 %");
  EXPECT_EQ(render("{{d 17500}} {{d 999}}"), "17 500 999");
}

TEST_F(PageTest, ACardIsARowWithTheNameOfItsFile) {
  testing::write_text(folder_.path() / "net-8.json",
                      R"({"error": {"mean": 0.25}, "fails_at": null})");
  EXPECT_EQ(render("{{.2f net-8.json net-8 error.mean}}"), "0.25");
  EXPECT_EQ(render("{{each net-8.json *: {label}: {.0f fails_at}}}"), "net-8: —");
}

TEST_F(PageTest, SimpleValuesAreDerived) {
  EXPECT_EQ(render("{{.1f (/ (t gn RIE) (t 'net a' RIE))}}"), "2.0");
  EXPECT_EQ(render("{{.3f (range (t net* RIE))}}"), "0.025 to 0.030");
  EXPECT_EQ(render("{{(best (t * RIE))}}"), "net a");
  EXPECT_EQ(render("{{(count (t type=net RIE))}} of {{(count (t * RIE))}}"), "2 of 3");
  EXPECT_EQ(render("{{(count (t/levels.csv share>0.05 share))}}"), "2");
  EXPECT_EQ(render("{{(best (- (t net* RIE) 0.5))}}"), "net a");
  EXPECT_EQ(render("{{.3f (- (t gn RIE) (t 'net a' RIE))}}"), "0.025");
}

TEST_F(PageTest, ALineIsMadeOfEveryRow) {
  EXPECT_EQ(render("{{each t *: | {label} | {.3f RIE}{ ± .3f seeds.deviation.RIE} | {.1f PE} |}}"),
            "| gn | 0.050 | — |\n| net a | 0.025 ± 0.001 | — |\n| net b | 0.030 | — |");
}

TEST_F(PageTest, NamesStandForSelections) {
  EXPECT_EQ(render("{{let nets net a|net b}}\n{{.3f (max (t '$nets' RIE))}}"), "0.030");
}

TEST_F(PageTest, AValueStandsWithItsInterval) {
  EXPECT_EQ(render("{{.3f t 'net a' RIE~}}"), "0.025 (0.020 to 0.030)");
  EXPECT_EQ(render("{{.2f t 'net a' RIE.ci95.0..RIE.ci95.1}}"), "0.02 to 0.03");
  testing::write_text(folder_.path() / "t/mm.csv", "solver,mm,mm_low,mm_high\ngn,2,1,4\n");
  EXPECT_EQ(render("{{.0f t/mm.csv gn mm~}}"), "2 (1 to 4)");
  EXPECT_NE(error("{{.3f t net* RIE~}}").find("takes one row"), std::string::npos);
}

TEST_F(PageTest, SeveralSelectionsMustAllHold) {
  EXPECT_EQ(render("{{let lv t/levels.csv axis=snr}}\n{{.2f $lv solver=net share}}"), "0.02");
}

TEST_F(PageTest, RowsAndCellsAreMadeOfLists) {
  EXPECT_EQ(render("{{rows row gn=Gauss|net b:\n| $row.name | "
                   "{{cells column RIE|latency_us.p50: {{.2f t '$row' $column}} |}}}}"),
            "| Gauss | 0.05 | 3.90 |\n| net b | 0.03 | 1200.00 |");
  EXPECT_NE(error("a\n{{rows row gn|lost: {{.2f t $row RIE}}}}").find("line 2"), std::string::npos);
}

/// A sentence that compares fails when what it says is no longer so.
TEST_F(PageTest, ConditionsAreHeldAgainstTheResults) {
  EXPECT_EQ(render("The net is best.{{holds (< (t net* RIE) (t gn RIE))}}"), "The net is best.");
  EXPECT_EQ(render("{{holds (< (t 'net a' RIE) (t 'net b' RIE) (t gn RIE))}}"), "");
  EXPECT_EQ(render("{{holds (= (/ (t gn RIE) (t 'net a' RIE)) 2 0.1)}}"), "");
  EXPECT_NE(error("one\n{{holds (< (t gn RIE) (t net* RIE))}}").find("line 2"), std::string::npos);
  EXPECT_NE(error("{{holds (< (t gn RIE) (t net* RIE))}}").find("does not hold"),
            std::string::npos);
  EXPECT_NE(error("{{holds (< (t gn RIE) (t 'net b' RIE))}}"), "");
}

TEST_F(PageTest, WhatIsNotThereIsAnErrorWithItsPlace) {
  EXPECT_NE(error("a\nb {{.3f t lost RIE}}").find("page.md.in: line 2"), std::string::npos);
  EXPECT_NE(error("{{.3f lost gn RIE}}").find("no such result"), std::string::npos);
  EXPECT_NE(error("{{.3f t gn PE}}").find("no PE"), std::string::npos);
  EXPECT_NE(error("{{.3f (/ 2 (t * RIE))}}").find("one number is meant"), std::string::npos);
  EXPECT_NE(error("{{.3f t gn RIE"), "");
  EXPECT_NE(error("{{each t gn: } {label}}").find("\"}\" is missing"), std::string::npos);
  EXPECT_NE(error("{{.3f t gn RIE.ci95.high}}").find("\"high\" is no place in a list"),
            std::string::npos);
  EXPECT_NE(error("{{.3f (/ 1)}}").find("takes more"), std::string::npos);
  EXPECT_NE(error("{{.3f 1}} {{.3x t gn RIE}}").find("not a format"), std::string::npos);
}

/// One of several names that is not there, or has no value, is not passed over.
TEST_F(PageTest, EachOfSeveralNamesIsThere) {
  EXPECT_NE(error("{{holds (< (t 'net a|lost' RIE) (t gn RIE))}}").find("no RIE of \"lost\""),
            std::string::npos);
  EXPECT_NE(error("{{(range (t 'net a|gn' seeds.deviation.RIE))}}").find("of \"gn\""),
            std::string::npos);
  EXPECT_NE(error("{{(range (t/levels.csv solver=gn|net,axis=dead share))}}").find("of \"net\""),
            std::string::npos);
  EXPECT_NE(error("{{each t 'gn|lost': {label}}}").find("no row of \"lost\""), std::string::npos);
  EXPECT_NE(error("{{.3f t lost* RIE}}").find("no RIE in the rows \"lost*\""), std::string::npos);
  // A limit asks which of them it leaves, and may leave none.
  EXPECT_EQ(render("{{(count (t/levels.csv solver=gn|net,axis=snr,share>0.05 share))}}"), "1");
  EXPECT_EQ(render("{{(count (t/levels.csv solver=net,share>0.5 share))}}"), "0");
}

TEST_F(PageTest, NumbersTypedByHandAreFound) {
  EXPECT_TRUE(
      literal_numbers("HDF5, C.3, `0.5` and [x](a_1.md), {{.3f t gn RIE}}\n```\n1\n```\n").empty());
  EXPECT_EQ(literal_numbers("It is 0.714 and\n37 times").size(), 2U);
  EXPECT_EQ(literal_numbers("x\nIt is 0.714").front(), "line 2: 0.714");
  EXPECT_TRUE(literal_numbers("<!-- constants: 95 %; 0.2 -->\n95 % of radius 0.2.").empty());
  // A constant is one number, not the beginning of others.
  EXPECT_EQ(literal_numbers("<!-- constants: 0.2 -->\n0.21 and 0.2").size(), 1U);
  EXPECT_EQ(literal_numbers("<!-- constants: 2 -->\n2.5 and 12").size(), 2U);
}

/// Every page of the project holds what its template makes of the results, byte for byte.
TEST(ProjectPages, StandAsTheirTemplatesMakeThem) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  const auto templates = page_templates(project);
  EXPECT_GE(templates.size(), 3U);
  for (const auto& one : templates) {
    const std::string text = testing::read_text(one);
    EXPECT_EQ(testing::read_text(page_of(one)),
              render_page(text, one.filename().string(), project / "results/published"))
        << one << ": render it with ertbench publish --pages";
  }
}

/// No page has a number that is not out of a result or declared as a constant of the method.
TEST(ProjectPages, HoldNoNumberTypedByHand) {
  const std::filesystem::path project = ERTBENCH_SOURCE_DIR;
  std::vector<std::filesystem::path> sources = page_templates(project);
  for (const auto& entry : std::filesystem::directory_iterator(project / "docs")) {
    const std::filesystem::path& page = entry.path();
    if (page.extension() == ".md" && !std::filesystem::exists(page.string() + ".in")) {
      sources.push_back(page);
    }
  }
  for (const auto& source : sources) {
    for (const std::string& found : literal_numbers(testing::read_text(source))) {
      ADD_FAILURE() << source << ": " << found;
    }
  }
}

}  // namespace
}  // namespace ertbench
