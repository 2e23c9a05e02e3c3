#include "bench/record/progress_file.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "core/errors.h"
#include "core/json_reader.h"
#include "core/json_text.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double pause_s = 0.5;
constexpr double longest_s = 1e9;  ///< more is no time that anybody would wait for

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
    left = std::min(longest_s, seconds_since(*start_) * static_cast<double>(total - done) /
                                   static_cast<double>(done - first_done_));
  }
  const double fraction =
      total > 0 ? std::min(1.0, static_cast<double>(done) / static_cast<double>(total)) : 0;
  const json content = {{"fraction", fraction}, {"text", text}, {"seconds_left", left}};
  // Renamed into place but not forced to the disk: it is of no use after a power cut.
  std::ofstream out(aside_of(file_));
  out << json_text(content);
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
  try {
    const json content = read_json_file(file);
    JsonObject object(content, file.string(), "");
    TrialProgress progress;
    progress.fraction = object.number("fraction", {0, 1});
    if (!object.raw("text").is_string()) return std::nullopt;
    progress.text = printable(object.raw("text").get_ref<const std::string&>());
    progress.seconds_left = object.number("seconds_left", {0, longest_s});
    return progress;
  } catch (const InputError&) {
    return std::nullopt;  // not there, or not written by us
  }
}

}  // namespace ertbench
