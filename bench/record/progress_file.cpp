#include "bench/record/progress_file.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double pause_s = 0.5;

fs::path aside_of(const fs::path& file) {
  fs::path aside = file;
  return aside += ".tmp";
}

}  // namespace

ProgressFile::ProgressFile(fs::path file) : file_(std::move(file)) {}

ProgressFile::~ProgressFile() { remove_progress(file_); }

void ProgressFile::update(std::uint64_t done, std::uint64_t total, const std::string& text) {
  const Clock::time_point now = Clock::now();
  const auto seconds_since = [&](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  if (!start_) {
    start_ = now;
    first_done_ = done;
  } else if (seconds_since(last_) < pause_s) {
    return;
  }
  last_ = now;
  double left = 0;
  if (done > first_done_ && done < total) {
    left = seconds_since(*start_) * static_cast<double>(total - done) /
           static_cast<double>(done - first_done_);
  }
  const double fraction =
      total > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total)) : 0;
  const json content = {{"fraction", fraction}, {"text", text}, {"seconds_left", left}};
  // Renamed into place but not forced to the disk: it is of no use after a power cut.
  std::ofstream out(aside_of(file_));
  out << content.dump(-1, ' ', false, json::error_handler_t::replace);
  out.close();
  std::error_code ignored;
  if (out) fs::rename(aside_of(file_), file_, ignored);
}

void remove_progress(const fs::path& file) {
  std::error_code ignored;
  fs::remove(file, ignored);
  fs::remove(aside_of(file), ignored);
}

std::optional<TrialProgress> read_progress(const fs::path& file) {
  std::ifstream in(file);
  if (!in) return std::nullopt;
  try {
    const json content = json::parse(in);
    return TrialProgress{content.at("fraction"), content.at("text"), content.at("seconds_left")};
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

}  // namespace ertbench
