#pragma once

#include <regex>
#include <string>
#include <vector>

namespace ertbench::testing {

/// What is wrong with HTML that is written like XML: tags that do not match, attributes without
/// quotes, a bare "&". Empty where all is well.
inline std::string markup_error(const std::string& text) {
  static const std::regex attributes(
      R"RE((\s+[A-Za-z_][-\w:.]*\s*=\s*("[^"<]*"|'[^'<]*'))*\s*/?)RE");
  static const std::regex bare("&(?!(amp|lt|gt|quot|#39|#[0-9]+);)");
  std::vector<std::string> open;
  std::size_t at = 0;
  while (true) {
    const std::size_t tag = text.find('<', at);
    const std::string words = text.substr(at, tag == std::string::npos ? tag : tag - at);
    if (std::regex_search(words, bare)) return "a bare & in: " + words;
    if (tag == std::string::npos) return open.empty() ? "" : "open at the end: " + open.back();
    const std::size_t end = text.find('>', tag);
    if (end == std::string::npos) return "a tag without an end";
    std::string inside = text.substr(tag + 1, end - tag - 1);
    at = end + 1;
    if (inside.starts_with("!")) continue;
    const bool closes = inside.starts_with("/");
    const std::string name =
        inside.substr(closes ? 1 : 0, inside.find_first_of(" \t\r\n/", 1) - (closes ? 1 : 0));
    if (closes) {
      if (open.empty() || open.back() != name) return "</" + name + "> closes nothing";
      open.pop_back();
      continue;
    }
    // Pictures are long, and of base64 alone.
    const std::size_t data = inside.find("data:image/png;base64,");
    if (data != std::string::npos) inside.erase(data, inside.find_first_of("\"'", data) - data);
    if (!std::regex_match(inside.substr(name.size()), attributes)) return "<" + inside + ">";
    if (inside.ends_with("/")) continue;
    if (name == "style" || name == "script") {
      at = text.find("</" + name + ">", at);
      if (at == std::string::npos) return name + " without an end";
    }
    open.push_back(name);
  }
}

/// The values of all attributes that the expression matches, in their order.
inline std::vector<std::string> attribute_values(const std::string& text, const std::string& name) {
  const std::regex attribute("\\s" + name + "=([\"'])([^\"']*)\\1");
  std::vector<std::string> values;
  for (std::sregex_iterator i(text.begin(), text.end(), attribute), end; i != end; ++i) {
    values.push_back((*i)[2]);
  }
  return values;
}

}  // namespace ertbench::testing
