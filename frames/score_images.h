#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {

/// Largest number of images in one picture.
inline constexpr std::size_t most_pictured = 12;

/// Throws InputError unless a table of images may be written as `file`: the file is missing or
/// holds such a table, and is none of the `inputs`.
void require_table_of_images(const std::filesystem::path& file,
                             const std::vector<std::filesystem::path>& inputs);
/// Throws InputError unless a picture may be written as `file`, whose name must end in ".png".
void require_picture(const std::filesystem::path& file,
                     const std::vector<std::filesystem::path>& inputs);

/// Writes the images of a file that reconstruct_file made as a table: a line of titles, then one
/// for each frame: "frame,status,reason,r0c0,r0c1,...", pixels in S/m, row 0 at the least y; empty
/// where an image is undefined.
void write_table_of_images(const std::filesystem::path& images, const std::filesystem::path& file);

/// Draws images of such a file as `file` and, beside it, as SVG: the given frames, by default all
/// of them or most_pictured at even distances. Throws InputError if the file lacks a frame.
void draw_images(const std::filesystem::path& images, const std::vector<std::uint64_t>& frames,
                 const std::filesystem::path& file);

struct ScoreOptions {
  std::filesystem::path images;
  std::filesystem::path truth;
  std::filesystem::path sensor;  ///< empty: the sensor of the truth's file, the images' file or d2s
  std::string dataset;           ///< the images'; empty: /conductivity_change, or /conductivity
};

struct ImageScores {
  int frames = 0;
  int undefined_frames = 0;  ///< without a usable image
  int flagged_frames = 0;    ///< with the status 3 (suspect)
  PerMetric<MetricSummary> metrics;
  /// Source of the true contacts: "contacts of the file" or "regions of the true images".
  std::string contacts;
  /// Signs that the images are of another unit, sign or orientation than the truths.
  std::vector<std::string> notes;
};

/// Scores every image by all metrics. `images`: HDF5 with /conductivity_change or /conductivity,
/// [N, rows, columns] or [N, pixels] S/m, and optionally /status [N] (2: undefined). `truth`: a
/// dataset file, or HDF5 with only /conductivity [N, rows, columns] S/m, whose contacts are then
/// the regions that the default rule reads from the true images. Throws InputError if the files do
/// not fit together: other sensors (but for the background of `images`), images or truths that are
/// no conductivities near the sensor's background, or statuses that do not exist.
ImageScores score_images(const ScoreOptions& options);

/// `{"schema", "frames", "undefined_frames", "flagged_frames", "contacts", "notes", "metrics":
/// {NAME: {"title" with the unit, "mean", "ci95", "median", "count", "undefined"}}}`; null where
/// there is no value.
nlohmann::json to_json(const ImageScores& scores);

}  // namespace ertbench
