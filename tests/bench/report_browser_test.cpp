// report.html of a real run, in a real browser: on a phone, on a desktop and on paper.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/text.h"
#include "tests/bench/browser.h"
#include "tests/bench/markup.h"
#include "tests/bench/small_experiment.h"

namespace ertbench {
namespace {

using nlohmann::json;
using namespace testing;

/// Shows the page of `srcdoc` as if in windows of 360 and 1200 px (a window itself is never less
/// than 500 px wide) and writes down what a reader would meet.
constexpr const char* kViewer = R"JS(
const frames = [...document.querySelectorAll('iframe')];
let loaded = 0;
function look(frame) {
  const page = frame.contentDocument, root = page.documentElement;
  const all = (query) => [...page.querySelectorAll(query)];
  const seen = {
    inner_width: frame.contentWindow.innerWidth,
    scroll_width: root.scrollWidth,
    title: page.title,
    labels: all('section:first-of-type tbody th').map(e =>
      [...e.querySelectorAll('.word')].map(word => word.textContent).join(' ')),
    columns: all('section:first-of-type thead th').length,
    cells: all('section:first-of-type tbody td').length,
    failures: all('section:first-of-type tbody th .more').map(e => e.textContent),
    boxes: all('.scroll').length,
    scrolling: all('.scroll').filter(e => e.scrollWidth > e.clientWidth).length,
    beyond_the_edge: all('body *').filter(e => !e.closest('.scroll') &&
      e.getBoundingClientRect().right > frame.contentWindow.innerWidth + 0.5).map(e => e.tagName),
    dangling: all('use').filter(e => !page.getElementById(
      e.getAttribute('xlink:href').slice(1))).length,
    repeated_ids: all('[id]').length - new Set(all('[id]').map(e => e.id)).size,
    collapsed: all('details').filter(e => !e.open).length,
  };
  // What the pointer meets over the last rectangle of each chart that is not folded away.
  const last = all('section > figure .tooltips').map(e => e.lastElementChild);
  seen.charts = last.length;
  seen.hovered = last.filter(e => {
    e.scrollIntoView({block: 'center', inline: 'center'});
    const box = e.getBoundingClientRect();
    return page.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2) === e;
  }).map(e => e.textContent);
  frame.contentWindow.dispatchEvent(new Event('beforeprint'));
  seen.collapsed_in_print = all('details').filter(e => !e.open).length;
  return seen;
}
frames.forEach(frame => frame.addEventListener('load', () => {
  if (++loaded < frames.length) return;
  const findings = document.createElement('pre');
  findings.id = 'findings';
  findings.textContent = JSON.stringify(frames.map(look));
  document.body.replaceChildren(findings);
}));
frames.forEach(frame => { frame.srcdoc = document.getElementById('page').textContent; });
)JS";

/// What stands in `<pre id="findings">` of the DOM.
json findings_in(const std::string& dom) {
  const std::string start = "<pre id=\"findings\">";
  const auto begin = dom.find(start);
  if (begin == std::string::npos) return {};
  std::string text = dom.substr(begin + start.size());
  text.resize(text.find("</pre>"));
  for (const auto& [from, to] : {std::pair("&lt;", "<"), {"&gt;", ">"}, {"&amp;", "&"}}) {
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + 1)) {
      text.replace(at, std::string(from).size(), to);
    }
  }
  return json::parse(text);
}

class ReportInBrowser : public ::testing::Test {
 protected:
  void SetUp() override {
    browser_ = find_browser();
    if (!browser_) GTEST_SKIP() << "no /usr/bin/chromium; apt-get install chromium";
    json experiment = small_experiment();
    experiment["title"] = "Disc & \"noise\" <50 dB>";
    experiment["plugins"] = {ERTBENCH_MISBEHAVING_PLUGIN};
    experiment["solvers"] = json::array(
        {{{"type", "tsvd"}, {"sweep", {{"rank", {20, 40}}}}},
         {{"type", "pdipm"}, {"sweep", {{"alpha", {1e-6, 1e-5}}, {"tolerance", {0.1, 0.01}}}}},
         {{"type", "misbehaving"}, {"label", "lost"}, {"how", "throw"}},
         {{"type", "toy-learned"}, {"label", "net"}, {"seeds", {1, 2}}, {"epochs", 12}}});
    experiment["charts"] =
        json::array({{{"type", "bars"}, {"name", "methods"}, {"solvers", {"tsvd", "lost", "net"}}},
                     {{"type", "heat-map"}, {"name", "sweep"}, {"solver", "pdipm"}}});
    write_text(folder_ / "small.json", experiment.dump());
    const Outcome outcome = run_program(folder_.path(), "run small.json");
    ASSERT_EQ(outcome.exit_code, 1) << outcome.output;  // a trial failed, as it was told
    ASSERT_TRUE(fs::exists(report())) << outcome.output;
  }

  fs::path report() const { return folder_ / "results/small/report.html"; }
  BrowserOutcome open(const fs::path& page, const std::string& arguments) const {
    return browse(*browser_, folder_.path(), page, arguments);
  }

  TemporaryFolder folder_{"report"};
  std::optional<fs::path> browser_;
};

TEST_F(ReportInBrowser, IsReadOnAPhoneAndOnADesktop) {
  const std::string html = read_text(report());
  EXPECT_EQ(markup_error(html), "");
  EXPECT_LT(html.size(), 3000000u);
  const fs::path page = folder_ / "viewer.html";
  write_text(page,
             "<!DOCTYPE html><meta charset=\"utf-8\"><body>"
             "<iframe width=\"360\" height=\"800\" style=\"border: 0\"></iframe>"
             "<iframe width=\"1200\" height=\"800\" style=\"border: 0\"></iframe>"
             "<textarea id=\"page\" hidden>" +
                 html_escaped(html) + "</textarea><script>" + kViewer + "</script>");
  const BrowserOutcome outcome = open(page, "--window-size=1300,900 --dump-dom");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.console, "");
  const json findings = findings_in(outcome.output);
  ASSERT_EQ(findings.size(), 2u) << outcome.output;
  for (const json& seen : findings) {
    SCOPED_TRACE(seen.dump(1));
    EXPECT_LE(seen.at("scroll_width"), seen.at("inner_width"));
    EXPECT_EQ(seen.at("beyond_the_edge"), json::array());
    EXPECT_EQ(seen.at("title"), "Disc & \"noise\" <50 dB>");
    EXPECT_EQ(seen.at("labels"),
              json({"truth", "no-contact", "tsvd rank=20", "tsvd rank=40",
                    "pdipm alpha=1e-06 tolerance=0.1", "pdipm alpha=1e-06 tolerance=0.01",
                    "pdipm alpha=1e-05 tolerance=0.1", "pdipm alpha=1e-05 tolerance=0.01", "lost",
                    "net"}));
    EXPECT_EQ(seen.at("cells"), 10 * (seen.at("columns").get<int>() - 1));
    json failures = seen.at("failures");  // and remarks on rows that did not fail
    std::erase_if(failures.get_ref<json::array_t&>(),
                  [](const json& text) { return text == "worse than no contact"; });
    ASSERT_EQ(failures.size(), 1u);
    EXPECT_NE(failures[0].get<std::string>().find("on fire"), std::string::npos);
    EXPECT_EQ(seen.at("boxes"), 6) << "two tables, two charts, reconstructions, training";
    EXPECT_EQ(seen.at("dangling"), 0);
    EXPECT_EQ(seen.at("repeated_ids"), 0);
    EXPECT_EQ(seen.at("charts"), 3);
    EXPECT_EQ(seen.at("hovered").size(), 3u);
    EXPECT_EQ(seen.at("collapsed"), 2);
    EXPECT_EQ(seen.at("collapsed_in_print"), 0);
  }
  EXPECT_EQ(findings[0].at("inner_width"), 360);
  EXPECT_GE(findings[0].at("scrolling"), 3) << "the table and the charts are wider than a phone";
  const std::string bar = findings[0].at("hovered").at(0);
  EXPECT_TRUE(bar.starts_with("net\nRIE: 0.")) << bar;
}

TEST_F(ReportInBrowser, IsPrinted) {
  const fs::path paper = folder_ / "report.pdf";
  const BrowserOutcome outcome =
      open(report(), "--no-pdf-header-footer --print-to-pdf=" + quoted(paper.string()));
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.console, "");
  const std::string pdf = read_text(paper);
  EXPECT_TRUE(pdf.starts_with("%PDF-"));
  std::size_t pages = 0;
  for (auto at = pdf.find("/Type /Page\n"); at != std::string::npos;
       at = pdf.find("/Type /Page\n", at + 1)) {
    ++pages;
  }
  // Results, charts, reconstructions, training curves and recipes do not fit on two sheets.
  EXPECT_GE(pages, 3u);
  // A4 across, in points: 297 mm x 210 mm.
  EXPECT_NE(pdf.find("/MediaBox [0 0 841"), std::string::npos);
}

/// That the other tests would see a page which asks for another file or fails.
TEST_F(ReportInBrowser, ConsoleOfABrokenPageIsSeen) {
  std::string html = read_text(report());
  html.insert(html.find("</main>"), "<img src=\"https://example.invalid/a.png\"/>");
  const fs::path page = folder_ / "broken.html";
  write_text(page, html);
  const BrowserOutcome outcome = open(page, "--dump-dom");
  EXPECT_NE(outcome.console.find("Content Security Policy"), std::string::npos) << outcome.console;
}

}  // namespace
}  // namespace ertbench
