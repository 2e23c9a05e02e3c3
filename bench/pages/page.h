#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ertbench {

/// Renders a template. Between double braces stand, a line for the reader each:
///
///     {{.3f table_c1 dd-ert RIE}}                   a value, see page_expression.h
///     {{holds (< (table_c1 dd-ert RIE) 0.05)}}      nothing, or an error where it does not hold
///     {{let classical one-step-gn|tsvd|pdipm}}      what $classical stands for from here on
///     {{each table_c1 $classical: | {label} | {.3f RIE}{ ± .3f seeds.deviation.RIE} |}}
///
/// `each` makes a line for every row: in single braces a column with its format, "—" where the row
/// has none; what stands before the format is left out together with such a value. A sentence that
/// compares has a `holds` behind it.
///
/// `results`: the folder that the files of references are in. `name` is for messages. Throws
/// InputError naming the page's line.
std::string render_page(const std::string& text, const std::string& name,
                        const std::filesystem::path& results);

/// The templates of the project, `*.md.in`; each page stands beside its template, without ".in".
std::vector<std::filesystem::path> page_templates(const std::filesystem::path& project);
/// The page that a template makes.
std::filesystem::path page_of(const std::filesystem::path& page_template);

/// Whatever holds prose for readers: the templates, and the pages of docs/ that need none.
std::vector<std::filesystem::path> page_sources(const std::filesystem::path& project);

/// Words with digits that stand literally in a page's source, "line 12: 0.714": outside of braces,
/// code, links and comments, and not among the constants that the page declares in a comment,
///
///     <!-- constants: 24 x 24; 95 %; [-1, 1] -->
///
/// Words that begin with a letter (HDF5, C.3) are names.
std::vector<std::string> literal_numbers(const std::string& text);

}  // namespace ertbench
