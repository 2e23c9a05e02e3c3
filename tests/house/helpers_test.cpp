// The tests of a folder are compiled in batches (tests/CMakeLists.txt). A helper of one file that
// is called as one that a header of the tests shares hides it from the files behind it in its
// batch, which may go on to compile, and then test something else.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace {

namespace fs = std::filesystem;

/// What stands at the left margin and looks like the definition of a function or of a constant.
std::set<std::string> helpers_of(const std::string& text) {
  static const std::regex definition(
      R"((?:^|\n)(?!TEST|INSTANTIATE|namespace|return|using|//|#)\w[\w:<>,&* ]*[ &*](\w+)(?:\(| = ))");
  std::set<std::string> names;
  for (std::sregex_iterator it(text.begin(), text.end(), definition), end; it != end; ++it) {
    names.insert((*it)[1]);
  }
  return names;
}

std::string text_of(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file).rdbuf();
  return out.str();
}

TEST(Helpers, OfOneTestHideNoneThatIsShared) {
  std::map<std::string, fs::path> shared;
  for (const auto& entry : fs::directory_iterator(ERTBENCH_SOURCE_DIR "/tests/bench")) {
    if (entry.path().extension() != ".h") continue;
    for (const std::string& name : helpers_of(text_of(entry.path()))) shared[name] = entry.path();
  }
  EXPECT_GT(shared.size(), 20u);
  for (const auto& entry : fs::directory_iterator(ERTBENCH_SOURCE_DIR "/tests/bench")) {
    if (entry.path().extension() != ".cpp") continue;
    for (const std::string& name : helpers_of(text_of(entry.path()))) {
      EXPECT_FALSE(shared.contains(name))
          << entry.path() << ": " << name << " stands in " << shared[name] << ": rename it";
    }
  }
}

TEST(Helpers, AreSeenInAText) {
  EXPECT_EQ(helpers_of("const json good = {};\n  int local(int);\nResultRow row_of(int a) {\n"
                       "TEST(A, B) {\nreturn f(1);\n"),
            (std::set<std::string>{"good", "row_of"}));
}

}  // namespace
