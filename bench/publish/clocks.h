#pragma once

#include <filesystem>
#include <vector>

#include "bench/record/cache.h"

namespace ertbench {

/// What a network is trained on for the clock alone. What its frame costs does not depend on its
/// weights, so that a single epoch of few scenes does.
inline constexpr int clock_scenes = 512;

/// The times of published results, taken again all together on this machine. All other numbers stay
/// as they were published, perhaps on another machine.
///
/// Round by round the solvers of all experiments take turns, so that what disturbs the machine for
/// a while, or makes it slower from one hour to the next, falls on all of them. Solvers are fitted
/// as the experiments say where the cache does not have them, but for those that are trained from
/// random numbers (clock_scenes).
class Clocks {
 public:
  /// Throws InputError for a result that is not published or was not timed, whose experiment has
  /// other datasets or labels than it had, or whose studies count times in: it has to be published
  /// again.
  Clocks(const std::vector<std::filesystem::path>& experiments, std::filesystem::path project,
         const Cache& cache);
  Clocks(const Clocks&) = delete;
  Clocks& operator=(const Clocks&) = delete;
  ~Clocks();

  /// Fits, `jobs` at a time, and times; records go to results/clocks. Throws InputError where a
  /// solver could not be fitted or timed.
  void take(int jobs) const;

  /// Writes what take() measured, or an earlier process of this very program, into
  /// results/published: the rows' times in summary.json, the tables, the charts and the page.
  /// Throws InputError where a record is missing; then everything stays as it was.
  void write() const;

 private:
  struct Part;
  struct Published;
  std::vector<Published> results_;
  Cache cache_;
};

}  // namespace ertbench
