#include "bench/report/report.h"

#include <fstream>
#include <iterator>

#include "bench/report/inline_svg.h"
#include "bench/report/report_style.h"
#include "bench/table/writers.h"
#include "core/errors.h"
#include "core/html.h"
#include "core/text.h"
#include "core/text_stream.h"

namespace ertbench {
namespace {

/// Prints a page.
class Page {
 public:
  std::string print(const Report& report) {
    head(report.title);
    out_ << "<h1>" << html_escaped(report.title) << "</h1>\n";
    paragraphs(report.question, " class=\"question\"");
    contents(report.sections);
    for (const ReportSection& one : report.sections) section(one);
    // Browsers that cannot open them by the style sheet.
    out_ << "</main>\n<script>addEventListener('beforeprint', () => "
            "document.querySelectorAll('details').forEach(d => { d.open = true; }));</script>\n"
            "</body>\n</html>\n";
    return out_.str();
  }

 private:
  void head(const std::string& title) {
    out_ << "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
            "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
            "img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\"/>\n"
            "<title>"
         << html_escaped(title) << "</title>\n<style>" << kReportStyle
         << "</style>\n</head>\n<body>\n<main>\n";
  }

  void contents(const std::vector<ReportSection>& sections) {
    if (sections.empty()) return;
    out_ << "<nav aria-label=\"Contents\"><ul>\n";
    for (std::size_t i = 0; i < sections.size(); ++i) {
      out_ << "<li><a href=\"#section" << i + 1 << "\">" << html_escaped(sections[i].title)
           << "</a></li>\n";
    }
    out_ << "</ul></nav>\n";
  }

  void section(const ReportSection& section) {
    out_ << "<section id=\"section" << ++sections_ << "\">\n";
    const std::string title = "<h2>" + html_escaped(section.title) + "</h2>";
    out_ << (section.collapsed ? "<details><summary>" + title + "</summary>" : title) << "\n";
    paragraphs(section.text, "");
    if (!section.figures.empty()) hint();
    for (const ReportFigure& one : section.figures) figure(one);
    for (const TableSection& one : section.tables) {
      if (one.columns.size() > 3) {
        out_ << "<p class=\"sideways\">The table scrolls sideways; its first column stays.</p>\n";
      }
      open_box(one.caption);
      out_ << html_of(one) << "</div>\n";
    }
    if (!section.notes.empty()) {
      out_ << "<ul class=\"notes\">\n";
      for (const std::string& note : section.notes) {
        out_ << "<li>" << html_escaped(note) << "</li>\n";
      }
      out_ << "</ul>\n";
    }
    if (!section.code.empty()) {
      out_ << "<pre><code>" << html_escaped(section.code) << "</code></pre>\n";
    }
    out_ << (section.collapsed ? "</details>\n" : "") << "</section>\n";
  }

  void paragraphs(const std::string& text, const std::string& attributes) {
    for (const std::string& paragraph : split(text, "\n\n")) {
      if (!paragraph.empty()) {
        out_ << "<p" << attributes << ">" << html_escaped(paragraph) << "</p>\n";
      }
    }
  }

  /// Once on the page, before the first chart.
  void hint() {
    if (hinted_) return;
    out_ << "<p class=\"hint\">The pointer on a chart shows the values beneath it.</p>\n";
    hinted_ = true;
  }

  /// A box that scrolls by itself, with the keyboard too.
  void open_box(const std::string& name) {
    out_ << "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\""
         << html_escaped(name) << "\">\n";
  }

  void figure(const ReportFigure& figure) {
    std::ifstream in(figure.svg, std::ios::binary);
    const std::string svg(std::istreambuf_iterator<char>(in), {});
    if (!in) throw InputError(figure.svg.string() + ": cannot be read; is the file there?");
    const std::string prefix = "figure" + std::to_string(++figures_) + "-";
    out_ << "<figure>\n<figcaption><b>" << html_escaped(figure.title) << "</b>"
         << (figure.caption.empty() ? "" : ": ") << html_escaped(figure.caption)
         << "</figcaption>\n";
    open_box(figure.title);
    out_ << inline_svg(svg, prefix, figure.title) << "\n</div>\n</figure>\n";
  }

  TextStream out_;
  int sections_ = 0;
  int figures_ = 0;
  bool hinted_ = false;
};

}  // namespace

std::string report_html(const Report& report) { return Page().print(report); }

}  // namespace ertbench
