#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/experiment/solver_entry.h"
#include "bench/record/record_file.h"

namespace ertbench {

class DatasetFile;

/// Where datasets and fitted solvers are kept, under a hash of everything that determines them: the
/// canonical JSON with every default filled in, seeds and format versions. Two experiments that
/// name the same training set share it, and whatever was fitted to it; so do solvers that differ
/// only in how they are applied (ParameterRole::inference).
class Cache {
 public:
  /// $ERTBENCH_CACHE, else the folder `cache` beside the experiments.
  static Cache standard();
  explicit Cache(std::filesystem::path folder, Reuse reuse = Reuse::same_code);

  std::filesystem::path dataset(const DatasetSpec& spec) const;
  /// That file, opened. Throws InputError where it is not the set of this spec.
  DatasetFile open_dataset(const DatasetSpec& spec) const;

  /// The file of a fitted solver; what it was fitted with stands beside it under `.json`.
  std::filesystem::path fitted_solver(const FitRecipe& recipe) const;
  /// Where the solver may leave checkpoints and logs while it is fitted.
  std::filesystem::path work_folder(const FitRecipe& recipe) const;
  /// The text whose hash is the name of that file.
  static nlohmann::json fitted_solver_key(const FitRecipe& recipe);

  const std::filesystem::path& folder() const { return folder_; }
  /// Which of its contents may be reused; the names of the files do not tell.
  Reuse reuse() const { return reuse_; }
  Cache with(Reuse reuse) const { return Cache(folder_, reuse); }

 private:
  std::filesystem::path folder_;
  Reuse reuse_ = Reuse::same_code;
};

/// A dataset or a fitted solver in the cache.
struct CachedThing {
  std::string kind;                          ///< "dataset", "solver", "kept" (core/kept.h)
  std::filesystem::path file;                ///< its own; others of it stand beside
  std::vector<std::filesystem::path> files;  ///< all that go with it
  std::uint64_t bytes = 0;
  double age_days = 0;      ///< since its file was last written
  std::string commit = {};  ///< of the build that made it; "unknown" where it does not say
  bool stale = false;       ///< its probes are no longer this program's, or it cannot be read
  bool in_use = false;      ///< a process fits it now
};

/// A share in the cache, of all processes that use it: of a run or whatever else needs what the
/// cache holds, or of what removes it.
class CacheShare {
 public:
  enum class Of { run, removal };
  /// A run waits for the end of a removal. Throws InputError at a removal while a run goes on.
  /// Nothing is shared in a folder that cannot be written.
  CacheShare(const Cache& cache, Of of);
  CacheShare(const CacheShare&) = delete;
  CacheShare& operator=(const CacheShare&) = delete;
  ~CacheShare();

 private:
  int descriptor_ = -1;
};

/// All that the cache holds, by kind and name. Nothing where there is no cache.
std::vector<CachedThing> cache_contents(const Cache& cache);

/// Removes it, so that the next run that needs it makes it again.
void remove_cached(const CachedThing& thing);

}  // namespace ertbench
