#pragma once

#include <filesystem>
#include <vector>

namespace ertbench {

/// Of a folder beside results/published/NAME while that is made, and of what it replaces: no
/// results.
inline constexpr const char* part_ending = ".part";
inline constexpr const char* before_ending = ".before";

/// Those below a folder of published results, by their names, without what is being made or
/// replaced.
std::vector<std::filesystem::path> published_folders(const std::filesystem::path& published);

/// An empty folder in which what is to stand in `folder` is made.
std::filesystem::path part_of(const std::filesystem::path& folder);

/// The same with what stands in `folder`, but for what replace_folder keeps.
std::filesystem::path copied_part_of(const std::filesystem::path& folder);

/// Puts `made` in the place of `folder`, with the templates of pages that stand there and their
/// pages, whole or not at all.
void replace_folder(const std::filesystem::path& folder, const std::filesystem::path& made);

}  // namespace ertbench
