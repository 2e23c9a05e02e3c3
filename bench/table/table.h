#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ertbench {

/// One cell. All texts are plain UTF-8; writers escape them. Strings convert to cells.
struct Cell {
  Cell() = default;
  Cell(std::string words) : text(std::move(words)) {}
  Cell(const char* words) : text(words) {}

  std::string text;                ///< "1.102", "one-step-gn"
  std::optional<double> value;     ///< the number behind the text, with all its digits
  std::string interval;            ///< beside the text or below it: "[1.092, 1.112]"
  std::vector<std::string> lines;  ///< further lines below the text

  bool operator==(const Cell&) const = default;
};

/// A number with that many decimals; a dash without a value.
Cell number_cell(const std::optional<double>& value, int decimals);

/// A number for programs: the shortest text that reads back as the same number; empty without a
/// value or if it is not finite.
Cell exact_cell(const std::optional<double>& value);

/// "[1.092, 1.112]".
std::string interval_text(const std::string& low, const std::string& high);

enum class Align { left, right };  ///< left for words, right for numbers

struct Column {
  Column(std::string its_title, Align its_align = Align::right, int its_part = 0)
      : title(std::move(its_title)), align(its_align), part(its_part) {}
  Column(const char* its_title) : Column(std::string(its_title)) {}

  std::string title;
  Align align;
  /// Part of a wide table: 0, 1, ... Narrow pages show the parts below each other, each with the
  /// first column.
  int part;

  bool operator==(const Column&) const = default;
};

/// The columns of a file for programs, by their names with blanks between them.
std::vector<Column> columns_named(std::string_view names);

/// Rows that share their columns.
struct TableSection {
  std::string caption;  ///< may be empty
  std::string text;     ///< a paragraph above the rows; may be empty
  std::vector<Column> columns;
  /// [row][column]. The first cell of a row is its name; further lines of it report problems.
  std::vector<std::vector<Cell>> rows;
  std::vector<std::string> notes;  ///< paragraphs below the rows

  /// Throws std::invalid_argument unless every row has one cell for each column.
  void require_cells() const;
};

/// Sections with their title, legend and command.
struct Table {
  std::string title;  ///< may be empty, like all but the sections
  std::string text;   ///< paragraphs above the sections, separated by empty lines
  std::vector<TableSection> sections;
  std::vector<std::string> legend;  ///< explains the columns, a list below the sections
  std::string command;              ///< reproduces the table
};

// Writers. All throw std::invalid_argument unless every row has one cell for each column.

/// Markdown: title and captions as headings, the legend as a list. Columns are padded, so that the
/// text reads as a table; further lines of a cell follow <br>.
std::string markdown_of(const Table& table);

/// A LaTeX `table` float for each section, with the legend below it, to \input into any document
/// class without packages. Each part of the columns is a tabular, to fit the width of a page.
std::string latex_of(const Table& table);

/// CSV: a line of titles and a line for each row (RFC 4180 quoting, UTF-8, \n). A cell is its
/// number with all digits, or its text; caption, notes, intervals and further lines are left out.
std::string csv_of(const TableSection& section);

/// An HTML <table> with its caption; a cell's interval and further lines have the class "more".
/// Text and notes are left to the page. Right-aligned columns have the class "number" and break
/// only where numbers stay readable.
std::string html_of(const TableSection& section);

/// Text for a terminal: title, sections with captions, padded columns, notes. The line of column
/// titles is left out if all are empty.
std::string terminal_of(const Table& table);

}  // namespace ertbench
