#include "bench/report/report.h"

#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// The value that takes the place of an attribute's; none: the attribute is left out.
using Change =
    std::function<std::optional<std::string>(std::string_view name, std::string_view value)>;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("SVG for the report: " + what);
}

/// One past the `>` of the tag that begins at `begin`; a `>` within quotes is none.
std::size_t end_of_tag(std::string_view svg, std::size_t begin) {
  char quote = 0;
  for (std::size_t i = begin; i < svg.size(); ++i) {
    const char c = svg[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return i + 1;
    }
  }
  refuse("a tag has no end");
}

std::string changed_tag(std::string_view tag, const Change& change) {
  constexpr std::string_view space = " \t\r\n";
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t quote = tag.find_first_of("'\"", at);
    if (quote == std::string_view::npos) return out += tag.substr(at);
    const std::size_t end = tag.find(tag[quote], quote + 1);
    const std::size_t equals = tag.rfind('=', quote);
    if (equals == std::string_view::npos || equals < at) refuse("a value without a name");
    const std::size_t name_end = tag.find_last_not_of(space, equals - 1) + 1;
    const std::size_t name = tag.find_last_of(space, name_end - 1) + 1;
    const auto value =
        change(tag.substr(name, name_end - name), tag.substr(quote + 1, end - quote - 1));
    if (value) {
      out += std::string(tag.substr(at, quote + 1 - at)) + *value + tag[quote];
    } else {
      out += tag.substr(at, name - at);
    }
    at = end + 1;
  }
}

std::string with_attributes(std::string_view svg, const Change& change) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t tag = svg.find('<', at);
    if (tag == std::string_view::npos) return out += svg.substr(at);
    out += svg.substr(at, tag - at);
    at = end_of_tag(svg, tag);
    out += changed_tag(svg.substr(tag, at - tag), change);
  }
}

bool is_link(std::string_view name) { return name == "href" || name.ends_with(":href"); }

constexpr std::string_view kUrl = "url(#";

/// The ids that links and styles refer to.
std::set<std::string, std::less<>> references(std::string_view svg) {
  std::set<std::string, std::less<>> ids;
  with_attributes(svg, [&](std::string_view name, std::string_view value) {
    if (is_link(name)) {
      if (value.starts_with('#')) {
        ids.emplace(value.substr(1));
      } else if (!value.starts_with("data:")) {
        refuse("refers to " + std::string(value));
      }
    }
    for (auto at = value.find(kUrl); at != std::string_view::npos; at = value.find(kUrl, at + 1)) {
      const std::size_t id = at + kUrl.size();
      ids.emplace(value.substr(id, value.find(')', id) - id));
    }
    return std::string(value);
  });
  return ids;
}

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
         << html_escaped(title) << "</title>\n<style>\n"
         << report_style() << "</style>\n</head>\n<body>\n<main>\n";
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

std::string inline_svg(const std::string& svg, const std::string& prefix, const std::string& name) {
  const std::size_t start = svg.find("<svg");
  const std::size_t end = svg.rfind("</svg>");
  if (start == std::string::npos || end == std::string::npos) refuse("no <svg> in it");
  const std::string_view picture =
      std::string_view(svg).substr(start, end + std::string_view("</svg>").size() - start);
  const auto used = references(picture);
  const auto renamed = [&](std::string_view attribute,
                           std::string_view value) -> std::optional<std::string> {
    if (attribute == "id") {
      if (!used.contains(value)) return std::nullopt;
      return prefix + std::string(value);
    }
    std::string out(value);
    if (is_link(attribute) && value.starts_with('#')) out.insert(1, prefix);
    for (auto at = out.find(kUrl); at != std::string::npos; at = out.find(kUrl, at + 1)) {
      out.insert(at + kUrl.size(), prefix);
    }
    return out;
  };
  std::string out = with_attributes(picture, renamed);
  out.insert(std::string_view("<svg").size(),
             " role=\"img\" aria-label=\"" + html_escaped(name) + "\"");
  return out;
}

std::string report_html(const Report& report) { return Page().print(report); }

}  // namespace ertbench
