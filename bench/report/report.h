#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/table/table.h"

namespace ertbench {

/// The style sheet of report.html: screens from 360 px up, and A4.
inline constexpr const char* kReportStyle = R"(
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; text-size-adjust: 100%; }
body { margin: 0; background: #fff; color: #1c1c1c; font: 1rem/1.5 system-ui, sans-serif; }
main { max-width: 84rem; margin: 0 auto; padding: 1rem; }
h1, p, li, summary, figcaption { overflow-wrap: anywhere; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0.5rem 0; }
h2 { font-size: 1.2rem; line-height: 1.3; margin: 0; }
section { margin: 2rem 0; }
p { margin: 0.5rem 0; max-width: 46rem; }
.question { font-size: 1.1rem; }
nav ul { display: flex; flex-wrap: wrap; gap: 0.2rem 1.2rem; margin: 1rem 0; padding: 0;
  list-style: none; }
a { color: #1a4f8b; }
.hint, .notes, figcaption, caption { color: #555; font-size: 0.875rem; }
.notes { max-width: 60rem; padding-left: 1.2rem; }
.scroll { overflow-x: auto; margin: 0.75rem 0; }
.sideways { display: none; margin: 0.25rem 0 0; color: #555; font-size: 0.875rem; }
.scroll:focus-visible, summary:focus-visible { outline: 2px solid #1a4f8b; outline-offset: 2px; }
table { border-collapse: separate; border-spacing: 0; font-size: 0.75rem; line-height: 1rem;
  font-variant-numeric: tabular-nums; }
caption { position: sticky; left: 0; max-width: calc(100vw - 2rem); padding-bottom: 0.4rem;
  text-align: left; }
th, td { padding: 0.3125rem 0.4rem; text-align: left; vertical-align: top; }
thead th { border-bottom: 2px solid #777; vertical-align: bottom; font-weight: 600; }
thead th:first-child { position: sticky; left: 0; z-index: 1; background: #fff; }
tbody th, tbody td { border-bottom: 1px solid #e2e2e2; }
tbody th { position: sticky; left: 0; min-width: 8.5rem; max-width: 15rem; background: #fff;
  font-weight: 600; overflow-wrap: break-word; }
.number { text-align: right; }
td:not(.number) { min-width: 6rem; }
.more { display: block; color: #555; font-size: 0.6875rem; line-height: 0.9375rem; }
.word { display: inline-block; max-width: 100%; overflow-wrap: break-word; }
tbody th .more { color: #a00000; font-weight: 400; overflow-wrap: anywhere; }
figure { margin: 1.5rem 0; }
figcaption b { color: #1c1c1c; }
.scroll svg { display: block; }
.tooltips rect:hover { stroke: #1c1c1c; stroke-opacity: 0.45; }
pre { margin: 0.75rem 0; padding: 0.75rem; background: #f4f4f4; font-size: 0.8125rem;
  white-space: pre-wrap; overflow-wrap: anywhere; }
summary { cursor: pointer; }
summary h2 { display: inline; }
@media (max-width: 40rem) { tbody th { min-width: 6rem; max-width: 7.5rem; } }
@media screen and (max-width: 60rem) { .sideways { display: block; } }
@media (hover: none) { .hint { display: none; } }
@page { size: A4 landscape; margin: 12mm; }
@media print {
  html { font-size: 9.5pt; }
  main { max-width: none; padding: 0; }
  nav, .hint { display: none; }
  p, .notes { max-width: none; }
  section { margin: 5mm 0; }
  h2, caption, thead, summary { break-after: avoid; }
  tr, figure { break-inside: avoid; }
  tbody tr:first-child { break-before: avoid; }
  .scroll { overflow: visible; }
  th, td { padding: 0.8mm 1mm; }
  thead th:first-child { position: static; }
  tbody th { position: static; min-width: 24mm; max-width: 40mm; background: none; }
  .scroll svg { max-width: 100%; max-height: 165mm; height: auto; }
  details::details-content { content-visibility: visible; block-size: auto; }
  summary { list-style: none; }
}
)";

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
  std::string title;
  std::string text;  ///< paragraphs, an empty line between them
  std::vector<ReportFigure> figures;
  std::vector<TableSection> tables;  ///< their captions and rows; texts and notes stand above
  std::vector<std::string> notes;    ///< a list
  std::string code;                  ///< shown as it is: a command, a file
  bool collapsed = false;            ///< opened by a click, and for printing
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
