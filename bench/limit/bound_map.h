#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

#include "forward/sheet/sensor.h"

namespace ertbench {

/// The Cramér-Rao bound of one disc of unknown place, size and conductivity, wherever it is on the
/// sheet: the least standard deviations of unbiased estimates from one frame.
struct BoundMap {
  Sensor sensor;  ///< whose image has a pixel a place
  /// [places] rms distance from the true centre and standard deviation of the radius, mm, at
  /// 50 dB (absolute); not finite where the disc is not on the sheet as a whole. Both are
  /// proportional to the noise.
  Eigen::RowVectorXd place_mm, radius_mm;
};

/// Of a disc of `radius` (domain units) and `ratio` by BorderModel::linearise.
BoundMap bound_map(const Sensor& sensor, double radius, double ratio);

inline constexpr double bound_map_db = 50;

/// The maps side by side, one a number of electrodes, and the bound against the signal-to-noise
/// ratio: what a better sensor would buy. `stem`.svg and `stem`.png. Throws InputError where
/// gnuplot is missing or a file cannot be written.
void draw_bound_maps(const std::vector<BoundMap>& maps, const std::string& title,
                     const std::filesystem::path& stem);

}  // namespace ertbench
