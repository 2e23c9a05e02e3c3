#include <algorithm>
#include <array>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/table.h"
#include "bench/report/table_cells.h"
#include "core/text.h"

namespace ertbench {
namespace {

using Replacement = std::pair<char32_t, const char*>;

constexpr std::array<Replacement, 16> kAscii = {{{U'\\', "\\textbackslash{}"},
                                                 {U'{', "\\{"},
                                                 {U'}', "\\}"},
                                                 {U'$', "\\$"},
                                                 {U'&', "\\&"},
                                                 {U'#', "\\#"},
                                                 {U'%', "\\%"},
                                                 {U'_', "\\_"},
                                                 {U'^', "\\textasciicircum{}"},
                                                 {U'~', "\\textasciitilde{}"},
                                                 {U'<', "\\ensuremath{<}"},
                                                 {U'>', "\\ensuremath{>}"},
                                                 {U'|', "\\ensuremath{|}"},
                                                 {U'"', "''"},
                                                 {U'\n', " "},
                                                 {U'\r', " "}}};

/// Names of U+03B1 ... U+03C9 in TeX's mathematics.
constexpr std::array kGreek = {
    "alpha", "beta",   "gamma",   "delta",  "varepsilon", "zeta", "eta",  "theta", "iota",
    "kappa", "lambda", "mu",      "nu",     "xi",         "o",    "pi",   "rho",   "varsigma",
    "sigma", "tau",    "upsilon", "varphi", "chi",        "psi",  "omega"};

constexpr std::array<Replacement, 18> kSymbols = {{{U'−', "\\ensuremath{-}"},
                                                   {U'—', "---"},
                                                   {U'–', "--"},
                                                   {U'…', "\\ldots{}"},
                                                   {U'µ', "\\ensuremath{\\mu}"},
                                                   {U'×', "\\ensuremath{\\times}"},
                                                   {U'·', "\\ensuremath{\\cdot}"},
                                                   {U'±', "\\ensuremath{\\pm}"},
                                                   {U'≤', "\\ensuremath{\\le}"},
                                                   {U'≥', "\\ensuremath{\\ge}"},
                                                   {U'‖', "\\ensuremath{\\|}"},
                                                   {U'√', "\\ensuremath{\\surd}"},
                                                   {U'°', "\\ensuremath{^\\circ}"},
                                                   {U'²', "\\ensuremath{^2}"},
                                                   {U'₀', "\\ensuremath{_0}"},
                                                   {U'“', "``"},
                                                   {U'”', "''"},
                                                   {U'’', "'"}}};

template <std::size_t N>
const char* find(const std::array<Replacement, N>& table, char32_t point) {
  const auto found = std::find_if(table.begin(), table.end(),
                                  [point](const Replacement& r) { return r.first == point; });
  return found == table.end() ? nullptr : found->second;
}

/// U+0080 ... U+07FF in UTF-8.
std::string two_bytes(char32_t point) {
  return {static_cast<char>(0xc0U | (point >> 6U)), static_cast<char>(0x80U | (point & 0x3fU))};
}

/// Text that every LaTeX since 2018 prints as it is meant, without packages. Letters of the Latin
/// alphabets stay, Greek ones and common symbols become mathematics, any other character becomes
/// its number.
std::string escaped(const std::string& text) {
  std::ostringstream out;
  char32_t previous = 0;
  for (const char32_t point : code_points(text)) {
    if (const char* ascii = find(kAscii, point)) {
      out << ascii;
    } else if (const char* symbol = find(kSymbols, point)) {
      out << symbol;
    } else if (point == U'-' && previous == U'-') {
      out << "{}-";  // two hyphens, not a dash
    } else if (point >= 0x20 && point < 0x7f) {
      out << static_cast<char>(point);
    } else if (point >= 0xc0 && point < 0x17f) {
      out << two_bytes(point);
    } else if (point >= 0x3b1 && point < 0x3b1 + kGreek.size()) {
      out << "\\ensuremath{\\" << kGreek[point - 0x3b1] << "}";
    } else {
      out << "[U+" << std::hex << std::uppercase << static_cast<unsigned>(point) << std::dec << "]";
    }
    previous = point;
  }
  return out.str();
}

std::string stacked(const Cell& cell, char alignment) {
  // "{}": a line may begin with a bracket, which would be read as an option of the line end.
  if (cell.size() == 1) return "{}" + escaped(cell[0]);
  std::string out = std::string("\\begin{tabular}[t]{@{}") + alignment + "@{}}";
  for (std::size_t i = 0; i < cell.size(); ++i) {
    out += (i > 0 ? "\\\\{}" : "{}") + escaped(cell[i]);
  }
  return out + "\\end{tabular}";
}

/// A cell in lines of at most `width` characters; the interval has a line of its own.
std::string narrow(const Cell& cell, std::size_t width, char alignment) {
  Cell lines;
  for (const std::string& line : cell) {
    const auto interval = std::min(line.find(" ["), line.size());
    for (std::string& part : wrapped(line.substr(0, interval), width)) {
      lines.push_back(std::move(part));
    }
    if (interval < line.size()) lines.push_back(line.substr(interval + 1));
  }
  return stacked(lines, alignment);
}

/// The label and the columns [first, end).
void print(std::ostream& out, const CellTable& table, std::size_t first, std::size_t end) {
  constexpr std::size_t label_width = 16;
  constexpr std::size_t number_width = 12;
  constexpr std::size_t head_width = 9;
  out << "\\begin{tabular}{@{}l" << std::string(end - first, 'r')
      << "@{}}\n\\hline\\noalign{\\vskip 2pt}\n";
  out << escaped(table.head[0]);
  for (std::size_t c = first; c < end; ++c) {
    out << " & " << narrow({table.head[c]}, head_width, 'r');
  }
  out << " \\\\\n\\hline\\noalign{\\vskip 2pt}\n";
  for (const auto& row : table.rows) {
    // What went wrong is said once, in the first of the two tabulars.
    out << narrow(first == 1 ? row[0] : Cell{row[0].front()}, label_width, 'l');
    for (std::size_t c = first; c < end; ++c) out << " & " << narrow(row[c], number_width, 'r');
    out << " \\\\\\noalign{\\vskip 2pt}\n";
  }
  out << "\\hline\n\\end{tabular}\n";
}

}  // namespace

std::string latex_table(std::span<const ResultRow> rows, const TableText& text) {
  std::ostringstream out;
  for (const CellTable& table : cell_tables(rows, text)) {
    out << "\\begin{table}[htbp]\n\\centering\\scriptsize\\setlength{\\tabcolsep}{3pt}\n"
        << "\\caption{" << escaped(text.title) << (text.title.empty() ? "" : ", ")
        << escaped(table.dataset) << ": " << escaped(table.description) << "}\n\\smallskip\n";
    print(out, table, 1, kPublishedColumns);
    out << "\n\\medskip\n\n";
    print(out, table, kPublishedColumns, table.head.size());
    out << "\n\\medskip\n\n\\begin{minipage}{\\linewidth}\\tiny\n";
    for (const std::string& note : table.notes) out << escaped(note) << "\\par\n";
    for (const std::string& entry : legend(rows, text)) out << escaped(entry) << "\n";
    if (!text.command.empty()) {
      out << "To make it again: \\texttt{" << escaped(text.command) << "}\n";
    }
    out << "\\end{minipage}\n\\end{table}\n\n";
  }
  return out.str();
}

}  // namespace ertbench
