#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/arrays.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Draws `stem`.svg and `stem`.png: images [n, pixels] of the change of the conductivity over the
/// background, side by side, each with a label below it. One scale for all, zero in its
/// middle; a bar of so many millimetres; dots are electrodes, row 0 is at the bottom. Pixels that
/// are not finite stay grey. Throws as draw_reconstruction_figure.
void draw_images_figure(const Sensor& sensor, const Images& changes,
                        const std::vector<std::string>& labels, const std::filesystem::path& stem);

}  // namespace ertbench
