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

/// Images that a solver once made of some frames, and makes again.
struct StoredImages {
  std::string row;               ///< of the line: "stored dcnn"
  std::filesystem::path spec;    ///< of the solver, as `reconstruct` takes it
  std::filesystem::path frames;  ///< HDF5
  std::filesystem::path before;  ///< the images as they are stored
  std::filesystem::path now;     ///< where today's go
  std::filesystem::path log;     ///< of the process that makes them
  double most = 0;               ///< largest relative change of a frame's image
};

/// Makes today's images in a process of its own; false where it failed.
bool make_images(const StoredImages& images);

/// A line with the largest relative difference (2-norm) of a frame's image, infinite where frames
/// or statuses are not the same; "worse" beyond `most`, or where there are no images of today,
/// "missing" where none are stored. Throws InputError where the stored images cannot be read.
CheckLine compare_images(const StoredImages& images);

/// A line "missing" for each of the `rows` that has none among `lines`.
void add_missing_images(const std::vector<std::string>& rows, std::vector<CheckLine>& lines);

/// Holds fitted solvers that are kept with the images they once made to those images. `folder` has
/// frames.h5 and of each solver NAME.json, a specification as `reconstruct` takes it, and
/// NAME.images.h5, what `reconstruct` made of the frames with it; results/baselines/networks/make
/// makes them. Only solvers of the `types` are taken. Each runs in a process of its own, which
/// leaves its images and log in `out`.
///
/// A line each, "stored NAME": the largest relative difference (2-norm) of a frame's image, at most
/// stored_image_tolerance; "missing" for each of the `expected` that is not in the folder. Throws
/// InputError for files that cannot be used.
std::vector<CheckLine> compare_stored_networks(const std::filesystem::path& folder,
                                               const std::set<std::string>& types,
                                               const std::vector<std::string>& expected,
                                               const std::filesystem::path& out);

/// The names of those in the folder.
std::vector<std::string> stored_networks(const std::filesystem::path& folder,
                                         const std::set<std::string>& types);

/// Networks that are trained anew for a few dozen steps and make images of a few frames.
///
/// The seeds' spread hides what a change of a training does to its images, and a stored network is
/// not trained at all. But 32 steps in float32 from a fixed seed are too few for rounding to grow:
/// kernels without AVX (libtorch, oneDNN, OpenBLAS) change the images by 1e-6, those of dd-ert by
/// 2e-4, where another order of the scenes, other noise, another loss or a layer that does not
/// learn change them by some tenths. `check` compares them with the images of the same trainings in
/// the baseline; a change of the training that is meant asks for `check --update`.
///
/// `folder` has experiment.json, whose learned solvers are trained and whose test set are the
/// frames, and of each label LABEL.images.h5. Only solvers of the `types` are trained, with their
/// datasets and fits in `cache`; today's images and logs go to `out`. Without the folder there are
/// none.
std::vector<StoredImages> short_trainings(const std::filesystem::path& folder,
                                          const std::set<std::string>& types, const Cache& cache,
                                          const std::filesystem::path& out, int jobs);

/// A line "trained LABEL" each: the largest relative difference of a frame's image, at most
/// short_training_tolerance; "missing" for each of the `expected` labels that was not trained.
std::vector<CheckLine> compare_trainings(const std::vector<StoredImages>& trainings,
                                         const std::vector<std::string>& expected);

/// Their labels.
std::vector<std::string> labels_of(const std::vector<StoredImages>& trainings);

/// Puts today's images in the place of the stored ones; false where one is missing, and then none
/// is replaced.
bool store_trainings(const std::vector<StoredImages>& trainings);

/// Trains the solvers of `labels` with `count` seeds each and gives their `rows` the means, the
/// seeds and, where a training failed, the status that came out; rows that have as many seeds
/// already stay as they are. The seeds are those of the experiment, filled up with the smallest
/// numbers from 1 that it does not have. Runs the experiment with just these solvers, with "seeds"
/// in place of "seed" and without timing, into `options.out`/seeds; what was trained before is
/// taken from the cache. Returns how many trials failed.
int train_over_seeds(const Experiment& experiment, const std::set<std::string>& labels, int count,
                     const Cache& cache, const RunOptions& options, std::vector<ResultRow>& rows);

/// What makes that of the experiment (apply_overrides): the rows of `labels` over seeds, and all
/// else as it is that their scores depend on.
std::vector<std::string> overrides_for_seeds(const Experiment& experiment,
                                             const std::set<std::string>& labels, int count);

/// The rows in a result folder's summary.json. Throws InputError.
std::vector<ResultRow> read_summary_rows(const std::filesystem::path& folder);

}  // namespace ertbench
