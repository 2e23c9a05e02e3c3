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
