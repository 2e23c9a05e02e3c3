#pragma once

#include <filesystem>
#include <functional>

namespace ertbench {

/// Draws one figure, `stem`.svg and `stem`.png. Where `draw` throws, a warning says so, `stem`.svg
/// holds the reason in place of the figure, and there is no `stem`.png: no drawing ends what it
/// belongs to. Returns whether it was drawn.
bool draw_or_say(const std::filesystem::path& stem, const std::function<void()>& draw);

}  // namespace ertbench
