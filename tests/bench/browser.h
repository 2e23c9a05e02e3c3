#pragma once

#include <array>
#include <cstdio>
#include <optional>
#include <string>

#include "tests/bench/program.h"

namespace ertbench::testing {

/// The Chromium that is installed, if there is one.
inline std::optional<fs::path> find_browser() {
  const fs::path chromium = "/usr/bin/chromium";
  return fs::exists(chromium) ? std::optional(chromium) : std::nullopt;
}

struct BrowserOutcome {
  int exit_code;
  std::string output;   ///< of --dump-dom
  std::string console;  ///< lines that the page wrote to its console, refused requests among them
};

/// Opens a page without a window, without a network and with a new profile in `folder`, which must
/// exist; `arguments` say what to do with it.
inline BrowserOutcome browse(const fs::path& browser, const fs::path& folder, const fs::path& page,
                             const std::string& arguments) {
  const fs::path errors = folder / "browser.log";
  const std::string command =
      "timeout 120 " + quoted(browser.string()) +
      " --headless --no-sandbox --disable-gpu --disable-quic --no-first-run"
      " --disable-background-networking --disable-component-update --disable-sync"
      " --disable-dev-shm-usage --enable-logging=stderr --user-data-dir=" +
      quoted((folder / "profile").string()) + " " + arguments + " " +
      quoted("file://" + page.string()) + " 2>" + quoted(errors.string()) + " </dev/null";
  FILE* pipe = ::popen(command.c_str(), "r");
  BrowserOutcome outcome{-1, "", ""};
  std::array<char, 4096> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    outcome.output.append(buffer.data(), n);
  }
  outcome.exit_code = ::pclose(pipe);
  std::ifstream in(errors);
  for (std::string line; std::getline(in, line);) {
    if (line.find(":CONSOLE") != std::string::npos) outcome.console += line + "\n";
  }
  fs::remove_all(folder / "profile");
  return outcome;
}

}  // namespace ertbench::testing
