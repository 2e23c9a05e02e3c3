#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/table/table.h"

namespace ertbench {

/// The style sheet of report.html: report.css, which the build embeds.
const std::string& report_style();

/// The picture of an SVG file as it may stand in an HTML page beside others: without the XML
/// declaration, ids that something refers to begin with `prefix`, all others are left out, and
/// `name` is read out in its place. Throws std::invalid_argument where the text is not SVG or
/// refers to anything outside itself.
std::string inline_svg(const std::string& svg, const std::string& prefix, const std::string& name);

/// A chart that has been drawn, or whose file says why not (draw_or_say).
struct ReportFigure {
  std::string title;
  std::filesystem::path svg;  ///< its file, which is copied into the page
  std::string caption;        ///< behind the title; may be empty
  bool drawn = true;
};

/// A heading and what stands below it, in this order; all but the title may be empty. All texts are
/// plain and escaped when they are printed.
struct ReportSection {
  std::string title = {};
  std::string text = {};  ///< paragraphs, an empty line between them
  std::vector<ReportFigure> figures = {};
  std::vector<TableSection> tables = {};  ///< their captions and rows; texts and notes stand above
  std::vector<std::string> notes = {};    ///< a list
  std::string code = {};                  ///< shown as it is: a command, a file
  bool collapsed = false;                 ///< opened by a click, and for printing
};

/// The page that a reader of an experiment's results opens.
struct Report {
  std::string title;
  std::string question;  ///< may be empty
  std::vector<ReportSection> sections;
};

/// One HTML file that needs nothing beside it: charts inlined, no script but the one that opens
/// collapsed sections for printing, no reference to another file. Wide tables and charts scroll in
/// boxes of their own. Throws InputError where an SVG cannot be read, std::invalid_argument where
/// it is none or a table's rows are not as long as its header.
std::string report_html(const Report& report);

}  // namespace ertbench
