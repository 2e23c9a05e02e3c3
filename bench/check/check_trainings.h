#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/check/stored_images.h"
#include "bench/record/cache.h"

namespace ertbench {

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

}  // namespace ertbench
