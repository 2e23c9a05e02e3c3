// Holds the weight of the project to budgets: code that a reader has to carry, and bytes that a
// clone has to fetch. A change that needs more raises a number here, where it is seen.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Budgets {
  std::size_t lines = 87200;        ///< of all C++ outside tests/
  std::size_t files = 506;          ///< of C++ outside tests/
  std::size_t median_lines = 110;   ///< of these files, at least
  std::size_t longest_lines = 450;  ///< of any of these files
  std::size_t readme_lines = 130;
  std::size_t docs_lines = 1500;    ///< of all pages of docs/
  std::uintmax_t tree_mb = 40;      ///< all tracked files
  std::uintmax_t results_mb = 16;   ///< results/ without networks
  std::uintmax_t networks_mb = 16;  ///< results/networks
  std::uintmax_t picture_kb = 150;  ///< any PNG
} constexpr budgets;

constexpr std::uintmax_t megabyte = 1000 * 1000;

/// Files that git tracks, relative to the project. Where there is no git, all that are in the
/// folders that are not built: then what a run has left in results/ is counted too.
std::vector<std::string> project_files() {
  const fs::path project = ERTBENCH_SOURCE_DIR;
  std::vector<std::string> files;
  if (std::FILE* git =
          popen(("git -C '" + project.string() + "' ls-files 2>/dev/null").c_str(), "r")) {
    std::array<char, 4096> line;
    while (std::fgets(line.data(), line.size(), git)) {
      std::string file = line.data();
      while (file.ends_with('\n')) file.pop_back();
      if (fs::is_regular_file(project / file)) files.push_back(file);
    }
    pclose(git);
  }
  if (!files.empty()) return files;
  for (auto it = fs::recursive_directory_iterator(project);
       it != fs::recursive_directory_iterator(); ++it) {
    const std::string name = it->path().filename().string();
    if (it.depth() == 0 && (name == "build" || name == "cache" || name == ".git")) {
      it.disable_recursion_pending();
    } else if (it->is_regular_file()) {
      files.push_back(fs::relative(it->path(), project).string());
    }
  }
  return files;
}

std::size_t lines_of(const std::string& file) {
  std::ifstream in(fs::path(ERTBENCH_SOURCE_DIR) / file);
  return static_cast<std::size_t>(
      std::count(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>(), '\n'));
}

TEST(Budgets, OfCodeAreKept) {
  std::vector<std::size_t> lengths;
  std::size_t lines = 0;
  std::size_t docs = 0;
  for (const std::string& file : project_files()) {
    if (file.starts_with("docs/") && file.ends_with(".md")) docs += lines_of(file);
    const bool cpp = file.ends_with(".h") || file.ends_with(".cpp");
    if (!cpp || file.starts_with("tests/")) continue;
    lengths.push_back(lines_of(file));
    lines += lengths.back();
    EXPECT_LE(lengths.back(), budgets.longest_lines) << file;
  }
  std::sort(lengths.begin(), lengths.end());
  ASSERT_FALSE(lengths.empty());
  EXPECT_LE(lines, budgets.lines);
  EXPECT_LE(lengths.size(), budgets.files);
  EXPECT_GE(lengths[lengths.size() / 2], budgets.median_lines);
  EXPECT_LE(lines_of("README.md"), budgets.readme_lines);
  EXPECT_LE(docs, budgets.docs_lines);
}

TEST(Budgets, OfTheTreeAreKept) {
  std::uintmax_t tree = 0, results = 0, networks = 0;
  for (const std::string& file : project_files()) {
    const std::uintmax_t size = fs::file_size(fs::path(ERTBENCH_SOURCE_DIR) / file);
    tree += size;
    if (file.ends_with(".png")) {
      EXPECT_LE(size, budgets.picture_kb * 1000) << file;
    }
    if (file.starts_with("results/networks/") || file.starts_with("results/baselines/networks/")) {
      networks += size;
    } else if (file.starts_with("results/")) {
      results += size;
    }
  }
  EXPECT_LE(tree, budgets.tree_mb * megabyte);
  EXPECT_LE(results, budgets.results_mb * megabyte);
  EXPECT_LE(networks, budgets.networks_mb * megabyte);
}

}  // namespace
