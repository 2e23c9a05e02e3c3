#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ertbench {

/// Most images in one picture.
inline constexpr std::size_t most_pictured = 12;

/// Throws InputError unless a table of images may be written as `file`: nothing stands there, or
/// one that was written before, and it is none of the `inputs`.
void require_table_of_images(const std::filesystem::path& file,
                             const std::vector<std::filesystem::path>& inputs);
/// The same for a picture, whose name must end in ".png".
void require_picture(const std::filesystem::path& file,
                     const std::vector<std::filesystem::path>& inputs);

/// Writes the images of a file that reconstruct_file made as a table: a line of titles, then one
/// for each frame: "frame,status,reason,r0c0,r0c1,...", pixels in S/m, row 0 at the least y; empty
/// where an image is undefined.
void write_table_of_images(const std::filesystem::path& images, const std::filesystem::path& file);

/// Draws images of such a file (draw_images_figure) as `file` and, beside it, as SVG: the frames
/// that are named, else all of them, or most_pictured at even distances. Throws InputError for a
/// frame that is not there.
void draw_images(const std::filesystem::path& images, const std::vector<std::uint64_t>& frames,
                 const std::filesystem::path& file);

}  // namespace ertbench
