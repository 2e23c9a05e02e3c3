#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "forward/sheet/sensor.h"
#include "limit/limit_run.h"

namespace ertbench {

/// Draws histograms of the truths' ranks among the samples of their posteriors (Talts et al. 2018),
/// which are flat if the posteriors are right. Rows are sets under the prior of their own scenes,
/// columns are limit_ranks. Writes `stem`.svg and `stem`.png. Throws InputError if gnuplot is
/// missing or a file cannot be written.
void draw_rank_figure(std::span<const SetLimit> limits, const std::string& title,
                      const std::filesystem::path& stem);

/// The Cramér-Rao bound of one disc of unknown position, size and conductivity, for each position
/// on the sheet: the smallest standard deviations of unbiased estimates from one frame.
struct BoundMap {
  Sensor sensor;  ///< the pixels of its image are the positions
  /// [pixels] rms distance from the true centre and standard deviation of the radius, mm, at 50 dB
  /// (absolute); not finite where the disc does not fit on the sheet. Both are proportional to the
  /// noise.
  Eigen::RowVectorXd place_mm, radius_mm;
};

/// Computes the bound of a disc of `radius` (domain units) and `ratio` by BorderModel::linearise.
BoundMap bound_map(const Sensor& sensor, double radius, double ratio);

inline constexpr double bound_map_db = 50;

/// Draws the maps side by side, one for each number of electrodes, and the bound against the
/// signal-to-noise ratio, into `stem`.svg and `stem`.png. Throws InputError if gnuplot is missing
/// or a file cannot be written.
void draw_bound_maps(const std::vector<BoundMap>& maps, const std::string& title,
                     const std::filesystem::path& stem);

}  // namespace ertbench
