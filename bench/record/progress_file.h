#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace ertbench {

/// What a trial is doing.
struct TrialProgress {
  double fraction = 0;      ///< done, 0 ... 1
  std::string text;         ///< the solver's: "epoch 5 of 12, validation error 0.412"
  double seconds_left = 0;  ///< 0 where there is no telling
};

/// A small file by which a trial's process tells the runner what it does: written whole at most
/// twice a second, removed in the end. A file that cannot be written is no reason to fail.
class ProgressFile {
 public:
  explicit ProgressFile(std::filesystem::path file);
  ProgressFile(const ProgressFile&) = delete;
  ProgressFile& operator=(const ProgressFile&) = delete;
  ~ProgressFile();

  void update(std::uint64_t done, std::uint64_t total, const std::string& text);

 private:
  using Clock = std::chrono::steady_clock;

  std::filesystem::path file_;
  std::optional<Clock::time_point> start_;  ///< of the first update
  std::uint64_t first_done_ = 0;            ///< then; a fit may go on where it stopped
  Clock::time_point last_;
};

/// Removes the file of a trial that could not do so itself, as it crashed or was killed.
void remove_progress(const std::filesystem::path& file);

/// Nothing where there is no such file, or none that can be read.
std::optional<TrialProgress> read_progress(const std::filesystem::path& file);

}  // namespace ertbench
