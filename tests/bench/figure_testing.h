#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>

namespace ertbench::testing {

namespace fs = std::filesystem;

/// Sets an environment variable for a while.
class Environment {
 public:
  Environment(std::string name, const std::string& value) : name_(std::move(name)) {
    if (const char* before = ::getenv(name_.c_str())) before_ = before;
    ::setenv(name_.c_str(), value.c_str(), 1);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;
  ~Environment() {
    if (before_) {
      ::setenv(name_.c_str(), before_->c_str(), 1);
    } else {
      ::unsetenv(name_.c_str());
    }
  }

 private:
  std::string name_;
  std::optional<std::string> before_;
};

/// A folder for results, and one for temporary files that must be empty in the end.
class FigureTest : public ::testing::Test {
 protected:
  FigureTest() {
    std::string name = (fs::temp_directory_path() / "ertbench-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    fs::create_directories(folder_ / "results");
    fs::create_directories(folder_ / "temporary");
    temporary_.emplace("TMPDIR", (folder_ / "temporary").string());
  }
  ~FigureTest() override {
    EXPECT_TRUE(fs::is_empty(folder_ / "temporary")) << "temporary files are left";
    temporary_.reset();
    fs::remove_all(folder_);
  }

  fs::path results() const { return folder_ / "results"; }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(results())) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }
  std::string read(const std::string& name) const {
    std::ifstream in(results() / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  fs::path folder_;
  std::optional<Environment> temporary_;
};

inline std::size_t count(const std::string& text, const std::string& word) {
  std::size_t n = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

/// An SVG picture without its tooltips, and they alone.
inline std::string drawn(const std::string& svg) {
  return svg.substr(0, svg.find("<g class=\"tooltips\""));
}
inline std::string tooltips(const std::string& svg) { return svg.substr(drawn(svg).size()); }

}  // namespace ertbench::testing
