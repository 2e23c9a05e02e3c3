#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bench/table/table.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Makes a line of numbers break only before "(" and "over" and after "to" and "%,".
std::string kept_together(const std::string& line) {
  std::string out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const std::string_view before = std::string_view(line).substr(0, i);
    const std::string_view after = std::string_view(line).substr(i);
    const bool breaks = after.starts_with(" (") || after.starts_with(" over") ||
                        before.ends_with(" to") || before.ends_with("%,");
    out += line[i] == ' ' && !breaks ? "\u00a0" : std::string(1, line[i]);
  }
  return out;
}

/// The lines of a cell; an interval has its own line.
std::vector<std::string> lines_of(const Cell& cell, Align align) {
  std::vector<std::string> lines = {cell.text};
  if (!cell.interval.empty()) lines.push_back(cell.interval);
  lines.insert(lines.end(), cell.lines.begin(), cell.lines.end());
  if (align == Align::right) {
    for (std::string& line : lines) line = kept_together(line);
  }
  return lines;
}

/// Keeps words of a name unbroken unless they are longer than a line: not "alpha=1e-" and "07".
std::string unbroken_words(const std::string& name) {
  std::string out;
  for (const std::string& word : split(name, " ")) {
    out += (out.empty() ? "" : " ") + ("<span class=\"word\">" + html_escaped(word)) + "</span>";
  }
  return out;
}

std::string more_lines(const std::vector<std::string>& lines) {
  std::string out;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    out += "<span class=\"more\">" + html_escaped(lines[i]) + "</span>";
  }
  return out;
}

const std::map<char32_t, const char*> kReplacements = {{U'\\', "\\textbackslash{}"},
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
                                                       {U'\r', " "},
                                                       {U'−', "\\ensuremath{-}"},
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
                                                       {U'’', "'"}};

/// Names of U+03B1 ... U+03C9 in TeX's mathematics.
constexpr std::array kGreek = {
    "alpha", "beta",   "gamma",   "delta",  "varepsilon", "zeta", "eta",  "theta", "iota",
    "kappa", "lambda", "mu",      "nu",     "xi",         "o",    "pi",   "rho",   "varsigma",
    "sigma", "tau",    "upsilon", "varphi", "chi",        "psi",  "omega"};

/// Escapes text for LaTeX since 2018 without packages. Latin letters stay, Greek letters and common
/// symbols become mathematics, other characters their code point.
std::string escaped(const std::string& text) {
  TextStream out;
  char32_t previous = 0;
  for (const char32_t point : code_points(text)) {
    const auto known = kReplacements.find(point);
    if (known != kReplacements.end()) {
      out << known->second;
    } else if (point == U'-' && previous == U'-') {
      out << "{}-";  // two hyphens, not a dash
    } else if (point >= 0x20 && point < 0x7f) {
      out << static_cast<char>(point);
    } else if (point >= 0xc0 && point < 0x17f) {
      std::string letter;
      append_utf8(letter, point);
      out << letter;
    } else if (point >= 0x3b1 && point < 0x3b1 + kGreek.size()) {
      out << "\\ensuremath{\\" << kGreek[point - 0x3b1] << "}";
    } else {
      out << "[U+" << std::hex << std::uppercase << static_cast<unsigned>(point) << std::dec << "]";
    }
    previous = point;
  }
  return out.str();
}

std::string stacked(const std::vector<std::string>& lines, char alignment) {
  // "{}": a bracket at the start of a line would be read as an option of the line end.
  if (lines.size() == 1) return "{}" + escaped(lines[0]);
  std::string out = std::string("\\begin{tabular}[t]{@{}") + alignment + "@{}}";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    out += (i > 0 ? "\\\\{}" : "{}") + escaped(lines[i]);
  }
  return out + "\\end{tabular}";
}

/// A cell in lines of at most `width` characters; the interval has a line of its own.
std::string narrow(const Cell& cell, std::size_t width, char alignment) {
  std::vector<std::string> lines = wrapped(cell.text, width);
  if (!cell.interval.empty()) lines.push_back(cell.interval);
  for (const std::string& line : cell.lines) {
    for (std::string& part : wrapped(line, width)) lines.push_back(std::move(part));
  }
  return stacked(lines, alignment);
}

char letter_of(const Column& column) { return column.align == Align::right ? 'r' : 'l'; }

/// Prints the first column and those of one part.
void print(std::ostream& out, const TableSection& section, int part) {
  constexpr std::size_t label_width = 16;
  constexpr std::size_t cell_width = 12;
  constexpr std::size_t head_width = 9;
  std::vector<std::size_t> columns;
  std::string letters = "l";
  for (std::size_t c = 1; c < section.columns.size(); ++c) {
    if (section.columns[c].part != part) continue;
    columns.push_back(c);
    letters += letter_of(section.columns[c]);
  }
  out << "\\begin{tabular}{@{}" << letters << "@{}}\n\\hline\\noalign{\\vskip 2pt}\n"
      << escaped(section.columns[0].title);
  for (const std::size_t c : columns) {
    out << " & " << narrow(section.columns[c].title, head_width, letter_of(section.columns[c]));
  }
  out << " \\\\\n\\hline\\noalign{\\vskip 2pt}\n";
  for (const auto& row : section.rows) {
    // Problems of a row are reported once, in the first tabular.
    out << narrow(part == 0 ? row[0] : Cell(row[0].text), label_width, 'l');
    for (const std::size_t c : columns) {
      out << " & " << narrow(row[c], cell_width, letter_of(section.columns[c]));
    }
    out << " \\\\\\noalign{\\vskip 2pt}\n";
  }
  out << "\\hline\n\\end{tabular}\n\n\\medskip\n\n";
}

/// "title, caption: text" without empty parts.
std::string caption_of(const Table& table, const TableSection& section) {
  std::string out = table.title;
  if (!section.caption.empty()) out += (out.empty() ? "" : ", ") + section.caption;
  if (!section.text.empty()) out += (out.empty() ? "" : ": ") + section.text;
  return escaped(out);
}

}  // namespace

std::string html_of(const TableSection& section) {
  section.require_cells();
  const auto class_of = [&](std::size_t c) {
    return c > 0 && section.columns[c].align == Align::right ? " class=\"number\"" : "";
  };
  TextStream out;
  out << "<table>\n<caption>" << html_escaped(section.caption) << "</caption>\n<thead><tr>";
  for (std::size_t c = 0; c < section.columns.size(); ++c) {
    out << "<th scope=\"col\"" << class_of(c) << ">" << html_escaped(section.columns[c].title)
        << "</th>";
  }
  out << "</tr></thead>\n<tbody>\n";
  for (const auto& row : section.rows) {
    const std::vector<std::string> name = lines_of(row.front(), Align::left);
    out << "<tr><th scope=\"row\">" << unbroken_words(name.front()) << more_lines(name) << "</th>";
    for (std::size_t c = 1; c < row.size(); ++c) {
      const std::vector<std::string> lines = lines_of(row[c], section.columns[c].align);
      out << "<td" << class_of(c) << ">" << html_escaped(lines.front()) << more_lines(lines)
          << "</td>";
    }
    out << "</tr>\n";
  }
  out << "</tbody>\n</table>\n";
  return out.str();
}

std::string latex_of(const Table& table) {
  TextStream out;
  for (const TableSection& section : table.sections) {
    section.require_cells();
    out << "\\begin{table}[htbp]\n\\centering\\scriptsize\\setlength{\\tabcolsep}{3pt}\n"
        << "\\caption{" << caption_of(table, section) << "}\n\\smallskip\n";
    int parts = 1;
    for (const Column& column : section.columns) parts = std::max(parts, column.part + 1);
    for (int part = 0; part < parts; ++part) print(out, section, part);
    out << "\\begin{minipage}{\\linewidth}\\tiny\n";
    for (const std::string& note : section.notes) out << escaped(note) << "\\par\n";
    if (!table.text.empty()) out << escaped(table.text) << "\\par\n";
    for (const std::string& entry : table.legend) out << escaped(entry) << "\n";
    if (!table.command.empty()) {
      out << "To reproduce it: \\texttt{" << escaped(table.command) << "}\n";
    }
    out << "\\end{minipage}\n\\end{table}\n\n";
  }
  return out.str();
}

}  // namespace ertbench
