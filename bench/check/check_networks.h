#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "bench/check/check.h"

namespace ertbench {

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

}  // namespace ertbench
