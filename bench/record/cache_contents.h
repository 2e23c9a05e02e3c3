#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/record/cache.h"

namespace ertbench {

/// A dataset or a fitted solver in the cache.
struct CachedThing {
  std::string kind;                          ///< "dataset", "solver"
  std::filesystem::path file;                ///< its own; others of it stand beside
  std::vector<std::filesystem::path> files;  ///< all that go with it
  std::uint64_t bytes = 0;
  double age_days = 0;      ///< since its file was last written
  std::string commit = {};  ///< of the build that made it; "unknown" where it does not say
  bool stale = false;       ///< made by other code than this program's, or it cannot be read
  bool in_use = false;      ///< a process fits it now
};

/// All that the cache holds, by kind and name. Nothing where there is no cache.
std::vector<CachedThing> cache_contents(const Cache& cache);

/// Removes it, so that the next run that needs it makes it again.
void remove_cached(const CachedThing& thing);

}  // namespace ertbench
