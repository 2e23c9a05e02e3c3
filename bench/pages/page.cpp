#include "bench/pages/page.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "bench/pages/page_expression.h"
#include "core/errors.h"
#include "core/files.h"
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

/// "BEFORE: LINE" in its two parts.
std::pair<std::string, std::string> line_of(const std::string& text) {
  std::size_t colon = text.find(':');
  while (colon < text.size() && std::string(" \n").find(text[colon + 1]) == std::string::npos) {
    colon = text.find(':', colon + 1);
  }
  if (colon >= text.size()) throw InputError("\":\" and a line are missing");
  return {text.substr(0, colon), trimmed(text.substr(colon + 1))};
}

bool is_format(const std::string& word) {
  return word == "d" || word == "us" || (word.size() > 2 && word[0] == '.');
}

/// The end of what begins with a brace at `open`; npos where its braces are not closed.
std::size_t end_of(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t at = open; at < text.size(); ++at) {
    depth += text[at] == '{' ? 1 : text[at] == '}' ? -1 : 0;
    if (depth == 0) return at + 1;
  }
  return std::string::npos;
}

class Page {
 public:
  Page(std::string name, const fs::path& results) : name_(std::move(name)), results_(results) {}

  /// `nested`: within a directive, whose line errors have.
  std::string render(const std::string& text, bool nested = false) {
    std::string out;
    std::size_t at = 0;
    while (true) {
      const std::size_t open = text.find("{{", at);
      out += text.substr(at, open - at);
      if (open == std::string::npos) return out;
      if (!nested)
        line_ = 1 + std::count(text.begin(), text.begin() + static_cast<long>(open), '\n');
      const std::size_t end = end_of(text, open);
      const std::string place = name_ + ": line " + std::to_string(line_) + ": ";
      if (end == std::string::npos) throw InputError(place + "\"}}\" is missing");
      const std::string inside = trimmed(text.substr(open + 2, end - open - 4));
      std::string made;
      try {
        made = directive(inside);
      } catch (const InputError& error) {
        if (nested) throw;
        throw InputError(place + "{{" + inside + "}}: " + error.what());
      }
      out += made;
      at = end;
      // A line of which nothing is left goes altogether.
      const bool alone = made.empty() && (out.empty() || out.back() == '\n');
      if (alone && at < text.size() && text[at] == '\n') ++at;
    }
  }

 private:
  std::string directive(const std::string& inside) {
    const auto [first, all] = head_of(inside);
    if (first == "rows" || first == "cells") return repeated(all, first == "rows" ? "\n" : " ");
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

  std::string with_names(std::string text) const {
    // From the back, so that of two names that begin alike the longer one is found.
    for (auto name = names_.rbegin(); name != names_.rend(); ++name) {
      text = replaced(std::move(text), "$" + name->first, name->second);
    }
    return text;
  }

  /// `text`: "NAME ITEM|ITEM...: TEXT".
  std::string repeated(const std::string& text, const std::string& separator) {
    const auto [before, pattern] = line_of(text);
    const auto [name, items] = head_of(with_names(before));
    std::string out;
    for (const std::string& item : split(items, "|")) {
      const std::vector<std::string> parts = split(item, "=");
      const std::string named = replaced(pattern, "$" + name + ".name", parts.back());
      out +=
          (out.empty() ? "" : separator) + render(replaced(named, "$" + name, parts.front()), true);
    }
    return out;
  }

  std::string lines(const std::string& text) {
    const auto [before, pattern] = line_of(text);
    const std::vector<std::string> words = words_of(before);
    if (words.size() != 2) throw InputError("each FILE ROWS: LINE");
    std::string out;
    for (const json* row : results_.select(words[0], words[1])) {
      out += (out.empty() ? "" : "\n") + line(pattern, *row);
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
      at = end_of(pattern, open);
      if (at == std::string::npos) throw InputError("\"}\" is missing");
      out += cell(pattern.substr(open + 1, at - open - 2), row);
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

  std::string name_;
  ResultRows results_;
  std::map<std::string, std::string> names_;
  long line_ = 0;
};

}  // namespace

std::string render_page(const std::string& text, const std::string& name, const fs::path& results) {
  return Page(name, results).render(text);
}

std::vector<fs::path> page_templates(const fs::path& project) {
  std::vector<fs::path> out;
  const fs::path published = project / "results/published";
  std::vector<fs::path> folders = {project, project / "docs", published};
  for (const auto& entry : fs::directory_iterator(published)) {
    if (entry.is_directory() && !entry.path().has_extension()) folders.push_back(entry.path());
  }
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().string().ends_with(".md.in")) out.push_back(entry.path());
    }
  }
  std::ranges::sort(out);
  return out;
}

fs::path page_of(const fs::path& page_template) {
  return page_template.parent_path() / page_template.stem();
}

std::vector<std::pair<fs::path, std::string>> rendered_pages(const fs::path& project) {
  std::vector<std::pair<fs::path, std::string>> out;
  for (const fs::path& page_template : page_templates(project)) {
    out.emplace_back(
        page_of(page_template),
        render_page(contents_of(page_template), fs::relative(page_template, project).string(),
                    project / "results/published"));
  }
  return out;
}

}  // namespace ertbench
