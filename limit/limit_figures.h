#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "forward/sheet/sensor.h"
#include "limit/limit_run.h"

namespace ertbench {

/// Histograms of the ranks of the truths among the samples of their posteriors (Talts et al. 2018),
/// a row for each set under the prior of its own scenes, a column for each of limit_ranks: flat
/// where the posteriors are right. `stem`.svg and `stem`.png. Throws InputError where gnuplot is
/// missing or a file cannot be written.
void draw_rank_figure(std::span<const SetLimit> limits, const std::string& title,
                      const std::filesystem::path& stem);

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
