#include "bench/pages/page.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "bench/pages/page_expression.h"
#include "core/errors.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \n");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \n") - first + 1);
}

/// Splits off the first word.
std::pair<std::string, std::string> head_of(const std::string& text) {
  const std::size_t blank = text.find_first_of(" \n");
  if (blank == std::string::npos) return {text, ""};
  return {text.substr(0, blank), trimmed(text.substr(blank))};
}

bool is_format(const std::string& word) {
  return word == "d" || word == "us" || (word.size() > 2 && word[0] == '.');
}

class Page {
 public:
  explicit Page(const fs::path& results) : results_(results) {}

  std::string directive(const std::string& inside) {
    const auto [head, rest] = head_of(with_names(inside));
    if (head == "let") {
      const auto [name, text] = head_of(rest);
      names_[name] = text;
      return "";
    }
    if (head == "holds") {
      if (evaluate(rest, results_).number() == 0) throw InputError("does not hold: " + rest);
      return "";
    }
    if (head == "each") return lines(rest);
    if (is_format(head)) return formatted(evaluate(rest, results_), head);
    return formatted(evaluate(head + " " + rest, results_), "d");
  }

 private:
  std::string with_names(std::string text) const {
    for (const auto& [name, meaning] : names_) {
      for (std::size_t at = 0; (at = text.find("$" + name, at)) != std::string::npos;) {
        text.replace(at, name.size() + 1, meaning);
        at += meaning.size();
      }
    }
    return text;
  }

  std::string lines(const std::string& text) {
    const std::size_t colon = text.find(": ");
    if (colon == std::string::npos) throw InputError("each FILE ROWS: LINE");
    const std::vector<std::string> words = words_of(text.substr(0, colon));
    if (words.size() != 2) throw InputError("each FILE ROWS: LINE");
    std::string out;
    for (const json* row : results_.select(words[0], words[1])) {
      out += (out.empty() ? "" : "\n") + line(trimmed(text.substr(colon + 1)), *row);
    }
    if (out.empty()) throw InputError("no rows \"" + words[1] + "\" in " + words[0]);
    return out;
  }

  static std::string line(const std::string& pattern, const json& row) {
    std::string out;
    std::size_t at = 0;
    while (true) {
      const std::size_t open = pattern.find('{', at);
      out += pattern.substr(at, open - at);
      if (open == std::string::npos) return out;
      const std::size_t close = pattern.find('}', open);
      if (close == std::string::npos) throw InputError("a \"}\" is missing");
      out += cell(pattern.substr(open + 1, close - open - 1), row);
      at = close + 1;
    }
  }

  /// "PREFIX.3f COLUMN" or "COLUMN".
  static std::string cell(const std::string& inside, const json& row) {
    const std::size_t blank = inside.find_last_of(' ');
    const std::string column = blank == std::string::npos ? inside : inside.substr(blank + 1);
    const json& value = value_in(row, column);
    std::string before = blank == std::string::npos ? "" : inside.substr(0, blank);
    const std::size_t word = before.find_last_of(' ');
    const std::string format = word == std::string::npos ? before : before.substr(word + 1);
    const std::string prefix = word == std::string::npos ? "" : before.substr(0, word + 1);
    if (value.is_null()) return prefix.empty() ? "—" : "";
    if (value.is_string()) return prefix + markdown_escaped(value.get<std::string>());
    if (!value.is_number()) throw InputError(column + " is no number");
    return prefix + formatted(value.get<double>(), format.empty() ? "d" : format);
  }

  ResultRows results_;
  std::map<std::string, std::string> names_;
};

std::size_t line_at(const std::string& text, std::size_t at) {
  return 1 + static_cast<std::size_t>(
                 std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
}

/// Blanks out what matches, line ends kept.
void blank_out(std::string& text, const std::regex& what) {
  std::string out;
  auto from = text.cbegin();
  for (std::sregex_iterator match(text.begin(), text.end(), what), end; match != end; ++match) {
    out.append(from, (*match)[0].first);
    for (auto c = (*match)[0].first; c != (*match)[0].second; ++c) out += *c == '\n' ? '\n' : ' ';
    from = (*match)[0].second;
  }
  text = out.append(from, text.cend());
}

/// Phrases of the comments "constants: a; b", the longest first.
std::vector<std::string> constants_of(const std::string& text) {
  static const std::regex comment("<!-- constants:([^>]*)-->");
  std::vector<std::string> out;
  for (std::sregex_iterator match(text.begin(), text.end(), comment), end; match != end; ++match) {
    for (const std::string& phrase : split((*match)[1].str(), ";")) {
      if (!trimmed(phrase).empty()) out.push_back(trimmed(phrase));
    }
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a.size() > b.size(); });
  return out;
}

bool is_part_of_number(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '.'; }

/// Blanks out a phrase wherever it stands as a whole.
void blank_out(std::string& text, const std::string& phrase) {
  for (std::size_t at = 0; (at = text.find(phrase, at)) != std::string::npos;) {
    const std::size_t after = at + phrase.size();
    const bool begins = at == 0 || !is_part_of_number(text[at - 1]);
    const bool ends =
        after >= text.size() || !std::isalnum(static_cast<unsigned char>(text[after]));
    const bool decimals = after + 1 < text.size() && text[after] == '.' &&
                          std::isdigit(static_cast<unsigned char>(text[after + 1]));
    if (begins && ends && !decimals) text.replace(at, phrase.size(), phrase.size(), ' ');
    at = after;
  }
}

}  // namespace

std::string render_page(const std::string& text, const std::string& name, const fs::path& results) {
  Page page(results);
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t open = text.find("{{", at);
    out += text.substr(at, open - at);
    if (open == std::string::npos) return out;
    const std::string place = name + ": line " + std::to_string(line_at(text, open)) + ": ";
    std::size_t close = text.find("}}", open);
    if (close == std::string::npos) throw InputError(place + "\"}}\" is missing");
    while (close + 2 < text.size() && text[close + 2] == '}') ++close;
    const std::string inside = trimmed(text.substr(open + 2, close - open - 2));
    std::string quoted = "{{";
    quoted.append(inside).append("}}: ");
    std::string made;
    try {
      made = page.directive(inside);
    } catch (const InputError& error) {
      throw InputError(place + quoted + error.what());
    }
    out += made;
    at = close + 2;
    // A line of which nothing is left goes altogether.
    const bool alone = made.empty() && (out.empty() || out.back() == '\n');
    if (alone && at < text.size() && text[at] == '\n') ++at;
  }
}

std::vector<fs::path> page_templates(const fs::path& project) {
  std::vector<fs::path> out;
  for (const fs::path& folder : {project, project / "docs"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().string().ends_with(".md.in")) out.push_back(entry.path());
    }
  }
  fs::recursive_directory_iterator published(project / "results/published");
  for (const fs::directory_entry& entry : published) {
    const fs::path& path = entry.path();
    // What publishing was cut off at (published_folder.h) has no pages.
    if (path.extension() == ".part" || path.extension() == ".before") {
      published.disable_recursion_pending();
    }
    if (path.string().ends_with(".md.in")) out.push_back(path);
  }
  std::sort(out.begin(), out.end());
  return out;
}

fs::path page_of(const fs::path& page_template) {
  return page_template.parent_path() / page_template.stem();
}

std::vector<fs::path> page_sources(const fs::path& project) {
  std::vector<fs::path> out = page_templates(project);
  for (const auto& entry : fs::directory_iterator(project / "docs")) {
    const fs::path& page = entry.path();
    if (page.extension() == ".md" && !fs::exists(page.string() + ".in")) out.push_back(page);
  }
  return out;
}

std::vector<std::string> literal_numbers(const std::string& text) {
  std::string rest = text;
  const std::vector<std::string> constants = constants_of(text);
  static const std::regex left_out[] = {
      std::regex("```[^`]*```"), std::regex("\\{\\{([^}]|\\}[^}])*\\}+"), std::regex("`[^`]*`"),
      std::regex("<!--([^-]|-[^-]|--[^>])*-->"), std::regex("\\]\\([^)\\s]*\\)")};
  for (const std::regex& what : left_out) blank_out(rest, what);
  for (const std::string& phrase : constants) blank_out(rest, phrase);
  std::vector<std::string> out;
  static const std::regex word("[A-Za-z0-9_.-]*[0-9][A-Za-z0-9_.%-]*");
  for (std::sregex_iterator match(rest.begin(), rest.end(), word), end; match != end; ++match) {
    const std::string found = (*match)[0].str();
    if (std::isalpha(static_cast<unsigned char>(found.front()))) continue;
    out.push_back("line " +
                  std::to_string(line_at(rest, static_cast<std::size_t>(match->position()))) +
                  ": " + found);
  }
  return out;
}

}  // namespace ertbench
