#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/plot/svg_tooltips.h"

namespace ertbench {

/// Files by name: texts and pictures alike.
using FileContents = std::map<std::string, std::string>;

/// Runs a gnuplot script in a temporary folder that holds `inputs`, and returns the files `outputs`
/// that it made there. The user's own gnuplot settings are not read. Throws InputError where
/// gnuplot is not installed, std::runtime_error with gnuplot's own words where it fails.
FileContents run_gnuplot(const std::string& script, const FileContents& inputs,
                         const std::vector<std::string>& outputs);

/// Draws one chart twice, as `stem`.svg and `stem`.png (`stem` with its folder, without an ending),
/// each put in place whole. `commands` draws it and sets neither terminal nor output; it may set
/// up a multiplot. `width` and `height` in px of the SVG, where a font's size is in px as well
/// (11 unless set); the PNG has three times as many, everything in it three times as large,
/// and no tooltips.
void draw_chart(const std::string& commands, const FileContents& inputs, int width, int height,
                const std::filesystem::path& stem, const std::vector<Tooltip>& tooltips = {});

/// `text` as a quoted string of gnuplot's, in which nothing has a meaning.
std::string gnuplot_string(const std::string& text);

}  // namespace ertbench
