#pragma once

#include <string>

#include "bench/table/table.h"

/// A table in five formats. All throw std::invalid_argument where a row has not one cell for each
/// column.
namespace ertbench {

/// A file of Markdown: the title as its heading, each section with its caption as a smaller one,
/// the legend as a list. Columns are padded, so that the text reads as a table too; what is under a
/// cell's text stands behind <br>.
std::string markdown_of(const Table& table);

/// For each section a `table` float to \input into any document class, with the legend below it.
/// Needs no package; a tabular for each part of the columns, so that it fits the width of a page.
std::string latex_of(const Table& table);

/// A line of titles and a line for each row (RFC 4180 quoting, UTF-8, lines end in \n). A cell is
/// the number behind it with all its digits, or its text; caption, notes, intervals and further
/// lines have no place there.
std::string csv_of(const TableSection& section);

/// A <table> with its caption; a cell's interval and further lines are of class "more". Text and
/// notes are left to the page. Columns to the right have the class "number" and break where numbers
/// can be read.
std::string html_of(const TableSection& section);

/// Lines for a terminal: title, sections with their captions, columns padded to the width of what
/// is in them, notes below. No titles of columns where all are empty.
std::string terminal_of(const Table& table);

}  // namespace ertbench
