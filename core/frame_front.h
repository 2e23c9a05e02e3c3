#pragma once

#include <cstdint>
#include <vector>

namespace ertbench {

/// What is done with a frame before its layers, as data: dead electrodes are found, their channels
/// are replaced by their mean given the live ones, and a network is told (FrameCheck, Front).
struct FrameFront {
  int electrodes = 0;                ///< 0: nothing is done
  int told = 0;                      ///< numbers behind the channels: dead electrodes, then noise
  int neighbours = 0;                ///< 1: the sensor drives adjacent pairs
  int of_change = 0;                 ///< 1: noise follows the change rather than the frame
  std::vector<int> pairs;            ///< [pairs, 2] channels, equal ones for a channel alone
  std::vector<std::uint64_t> users;  ///< [pairs] their electrodes, as bits
  std::vector<int> least_bad;        ///< [electrodes] bad pairs at which one is dead
  std::vector<double> reference;     ///< [channels] V, of the frames of the fit
  double reference_square = 0;       ///< V^2, mean square of the model's, by which noise is told
  double noise = 0;                  ///< V^2, usual square of the pairs' differences ...
  double noise_slope = 0;            ///< ... and per square of the frame, or of its change
  double limit = 0;                  ///< so often as much is unusual
  double least_size = 0;             ///< V^2, of a change
  double residual = 0;               ///< V^2, that the directions leave of a frame ...
  double residual_slope = 0;         ///< ... and per square of its change
  std::vector<float> directions;     ///< [pairs, directions], whose squares are the moments
};

}  // namespace ertbench
