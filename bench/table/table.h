#pragma once

#include <optional>
#include <string>
#include <vector>

namespace ertbench {

/// One cell. All texts are plain UTF-8 and are escaped by the writers. Words and numbers that were
/// made into text elsewhere become a cell by themselves.
struct Cell {
  Cell() = default;
  Cell(std::string words) : text(std::move(words)) {}
  Cell(const char* words) : text(words) {}

  std::string text;                ///< what is read first: "1.102", "one-step-gn"
  std::optional<double> value;     ///< the number behind the text, with all its digits
  std::string interval;            ///< beside the text or below it: "[1.092, 1.112]"
  std::vector<std::string> lines;  ///< what more there is to say, a line each

  bool operator==(const Cell&) const = default;
};

/// A number with that many decimals; a dash where there is none.
Cell number_cell(const std::optional<double>& value, int decimals);

/// A number for programs: the shortest text that reads back as the same one; empty where there is
/// none or it is not finite.
Cell exact_cell(const std::optional<double>& value);

/// "[1.092, 1.112]".
std::string interval_text(const std::string& low, const std::string& high);

enum class Align { left, right };  ///< of words and of numbers

struct Column {
  Column(std::string its_title, Align its_align = Align::right, int its_part = 0)
      : title(std::move(its_title)), align(its_align), part(its_part) {}
  Column(const char* its_title) : Column(std::string(its_title)) {}

  std::string title;
  Align align;
  /// Where a page is narrow, the parts of a wide table stand below each other: 0, 1, ... The first
  /// column stands in all of them.
  int part;

  bool operator==(const Column&) const = default;
};

/// Rows that share their columns.
struct TableSection {
  std::string caption;  ///< may be empty
  std::string text;     ///< a paragraph above the rows; may be empty
  std::vector<Column> columns;
  /// [row][column]. The first cell of a row names it; its further lines say what went wrong.
  std::vector<std::vector<Cell>> rows;
  std::vector<std::string> notes;  ///< paragraphs below the rows

  /// Throws std::invalid_argument where a row has not one cell for each column.
  void require_cells() const;
};

/// What is printed as one: the sections, and what stands around them.
struct Table {
  std::string title;  ///< all but the sections may be empty
  std::string text;   ///< paragraphs above them, an empty line between two
  std::vector<TableSection> sections;
  std::vector<std::string> legend;  ///< how to read the columns: a list below the sections
  std::string command;              ///< makes it again
};

}  // namespace ertbench

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
