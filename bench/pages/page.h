#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ertbench {

/// Renders a template. Between double braces stand:
///
///     {{.3f table_c1 dd-ert RIE}}                   a value, see page_expression.h
///     {{.3f table_c1 dd-ert RIE~}}                  with its interval, "0.050 (0.045 to 0.055)"
///     {{holds (< (table_c1 dd-ert RIE) 0.05)}}      nothing, or an error where it does not hold
///     {{let classical one-step-gn|tsvd|pdipm}}      what $classical stands for from here on
///     {{each table_c1 $classical: | {label} | {.3f RIE}{ ± .3f seeds.deviation.RIE} |}}
///     {{rows row tsvd=TSVD|lean-net: | $row.name | {{cells column RIE|PE: {{.3f table_c1 $row
///     $column}} |}}}}
///
/// `each` makes a line for every row: in single braces a column with its format, "—" where the row
/// has none; what stands before the format is left out together with such a value. `rows` renders
/// its text for every item, a line each, `cells` one behind the other: $row is the item, $row.name
/// what stands behind its "=". A sentence that compares has a `holds` behind it.
///
/// `results`: the folder that the files of references are in. `name` is for messages. Throws
/// InputError naming the page's line.
std::string render_page(const std::string& text, const std::string& name,
                        const std::filesystem::path& results);

/// The templates of the project, `*.md.in`; each page stands beside its template, without ".in".
std::vector<std::filesystem::path> page_templates(const std::filesystem::path& project);
/// The page that a template makes.
std::filesystem::path page_of(const std::filesystem::path& page_template);

/// The pages of the project with their texts, as they ought to stand.
std::vector<std::pair<std::filesystem::path, std::string>> rendered_pages(
    const std::filesystem::path& project);

}  // namespace ertbench
