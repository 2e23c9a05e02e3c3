#include "bench/report/inline_svg.h"

#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include "core/html.h"

namespace ertbench {
namespace {

/// The value that takes the place of an attribute's; none: the attribute is left out.
using Change =
    std::function<std::optional<std::string>(std::string_view name, std::string_view value)>;

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("SVG for the report: " + what);
}

/// One past the `>` of the tag that begins at `begin`; a `>` within quotes is none.
std::size_t end_of_tag(std::string_view svg, std::size_t begin) {
  char quote = 0;
  for (std::size_t i = begin; i < svg.size(); ++i) {
    const char c = svg[i];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '>') {
      return i + 1;
    }
  }
  refuse("a tag has no end");
}

std::string changed_tag(std::string_view tag, const Change& change) {
  constexpr std::string_view space = " \t\r\n";
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t quote = tag.find_first_of("'\"", at);
    if (quote == std::string_view::npos) return out += tag.substr(at);
    const std::size_t end = tag.find(tag[quote], quote + 1);
    const std::size_t equals = tag.rfind('=', quote);
    if (equals == std::string_view::npos || equals < at) refuse("a value without a name");
    const std::size_t name_end = tag.find_last_not_of(space, equals - 1) + 1;
    const std::size_t name = tag.find_last_of(space, name_end - 1) + 1;
    const auto value =
        change(tag.substr(name, name_end - name), tag.substr(quote + 1, end - quote - 1));
    if (value) {
      out += std::string(tag.substr(at, quote + 1 - at)) + *value + tag[quote];
    } else {
      out += tag.substr(at, name - at);
    }
    at = end + 1;
  }
}

std::string with_attributes(std::string_view svg, const Change& change) {
  std::string out;
  std::size_t at = 0;
  while (true) {
    const std::size_t tag = svg.find('<', at);
    if (tag == std::string_view::npos) return out += svg.substr(at);
    out += svg.substr(at, tag - at);
    at = end_of_tag(svg, tag);
    out += changed_tag(svg.substr(tag, at - tag), change);
  }
}

bool is_link(std::string_view name) { return name == "href" || name.ends_with(":href"); }

constexpr std::string_view kUrl = "url(#";

/// The ids that links and styles refer to.
std::set<std::string, std::less<>> references(std::string_view svg) {
  std::set<std::string, std::less<>> ids;
  with_attributes(svg, [&](std::string_view name, std::string_view value) {
    if (is_link(name)) {
      if (value.starts_with('#')) {
        ids.emplace(value.substr(1));
      } else if (!value.starts_with("data:")) {
        refuse("refers to " + std::string(value));
      }
    }
    for (auto at = value.find(kUrl); at != std::string_view::npos; at = value.find(kUrl, at + 1)) {
      const std::size_t id = at + kUrl.size();
      ids.emplace(value.substr(id, value.find(')', id) - id));
    }
    return std::string(value);
  });
  return ids;
}

}  // namespace

std::string inline_svg(const std::string& svg, const std::string& prefix, const std::string& name) {
  const std::size_t start = svg.find("<svg");
  const std::size_t end = svg.rfind("</svg>");
  if (start == std::string::npos || end == std::string::npos) refuse("no <svg> in it");
  const std::string_view picture =
      std::string_view(svg).substr(start, end + std::string_view("</svg>").size() - start);
  const auto used = references(picture);
  const auto renamed = [&](std::string_view attribute,
                           std::string_view value) -> std::optional<std::string> {
    if (attribute == "id") {
      if (!used.contains(value)) return std::nullopt;
      return prefix + std::string(value);
    }
    std::string out(value);
    if (is_link(attribute) && value.starts_with('#')) out.insert(1, prefix);
    for (auto at = out.find(kUrl); at != std::string::npos; at = out.find(kUrl, at + 1)) {
      out.insert(at + kUrl.size(), prefix);
    }
    return out;
  };
  std::string out = with_attributes(picture, renamed);
  out.insert(std::string_view("<svg").size(),
             " role=\"img\" aria-label=\"" + html_escaped(name) + "\"");
  return out;
}

}  // namespace ertbench
