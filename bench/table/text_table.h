#pragma once

#include <string>
#include <vector>

namespace ertbench {

/// A table of plain text, to be escaped by whoever prints it.
struct TextTable {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< each as long as the header
};

/// As a section of a Markdown file.
std::string markdown_of(const TextTable& table);

}  // namespace ertbench
