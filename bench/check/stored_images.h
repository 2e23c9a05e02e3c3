#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/check/check.h"
#include "bench/record/cache.h"
#include "bench/record/result_row.h"
#include "bench/run/runner.h"

namespace ertbench {

/// Stored images of some frames, and those the solver makes today.
struct StoredImages {
  std::string name;              ///< of the network, or the label of the training: "dcnn"
  std::filesystem::path spec;    ///< the solver's, for `reconstruct`
  std::filesystem::path frames;  ///< HDF5
  std::filesystem::path before;  ///< the stored images
  std::filesystem::path now;     ///< today's images
  std::filesystem::path log;     ///< of the process that makes them
  double most = 0;               ///< largest allowed relative change of a frame's image
};

/// Fitted solvers with their stored images. `folder` has frames.h5 and, for each solver, NAME.json,
/// a specification for `reconstruct`, and NAME.images.h5, the images that `reconstruct` made, of
/// which a frame's may differ by stored_image_tolerance; results/baselines/networks/make makes
/// them. Only solvers of the `types` are taken. Each runs in a child process, which leaves its
/// images and log in `out`. Throws InputError for unusable files.
std::vector<StoredImages> stored_networks(const std::filesystem::path& folder,
                                          const std::set<std::string>& types,
                                          const std::filesystem::path& out);

/// Trains networks for a few dozen steps and makes images of a few frames.
///
/// The seeds' spread hides the effect of a changed training on images, and stored networks are not
/// trained. 32 steps in float32 from a fixed seed are too few for rounding to grow: kernels without
/// AVX (libtorch, oneDNN, OpenBLAS) change the images by 1e-6, those of dd-ert by 2e-4, while
/// another order of the scenes, other noise, another loss or a layer that does not learn change
/// them by some tenths. After an intended change of a training use `check --update`.
///
/// `folder` has experiment.json, whose learned solvers are trained and whose test set provides the
/// frames, and LABEL.images.h5 for each label, from which a frame's may differ by
/// short_training_tolerance. Only solvers of the `types` are trained, with
/// datasets and fits in `cache`; today's images and logs go to `out`. Returns none without the
/// folder.
std::vector<StoredImages> short_trainings(const std::filesystem::path& folder,
                                          const std::set<std::string>& types, const Cache& cache,
                                          const std::filesystem::path& out, int jobs);

/// Returns a line "KIND NAME" each, of the kind "stored" or "trained": the largest relative
/// difference (2-norm) of a frame's image; "missing" for each of the `expected` names that is not
/// among the images.
std::vector<CheckLine> compare_images(const std::string& kind,
                                      const std::vector<StoredImages>& images,
                                      const std::vector<std::string>& expected);

/// Replaces the stored images by today's; returns false, without replacing any, if one is missing.
bool store_trainings(const std::vector<StoredImages>& trainings);

/// Trains the solvers of `labels` with `count` seeds each and gives their `rows` the means, the
/// seeds and, if a training failed, its status; rows with as many seeds are left unchanged. The
/// seeds are those of the experiment, filled up with the smallest other numbers from 1. Runs the
/// experiment with only these solvers, with "seeds" instead of "seed" and without timing, into
/// `options.out`/seeds; earlier trainings come from the cache. Returns the number of failed trials.
int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows);

/// The overrides (apply_overrides) that make this experiment: the rows of `labels` over seeds, with
/// everything else that their scores depend on.
std::vector<std::string> overrides_for_seeds(const Experiment& experiment,
                                             const std::set<std::string>& labels, int count);

/// The rows in a result folder's summary.json. Throws InputError.
std::vector<ResultRow> read_summary_rows(const std::filesystem::path& folder);

}  // namespace ertbench
