#pragma once

#include <string>
#include <vector>

namespace ertbench {

/// Scenes whose time is taken as one.
inline constexpr int fidelity_block = 16;  // two of the condensation's eight lanes

/// One model of the sheet on some scenes of one distribution.
struct FidelityRow {
  std::string dataset;
  std::string scenes;   ///< "smooth", "other" or "all"
  std::string model;    ///< "auto", or the grid's side
  int count = 0;        ///< scenes, blank ones left out: every model is exact there
  double time_us = 0;   ///< median time of a scene on one thread, rasterising included where needed
  double time_low = 0;  ///< 5 and 95 % of the blocks of scenes that are timed as one
  double time_high = 0;
  double error_median = 0;  ///< of the voltage changes, 2-norm, in units of the frame's noise
  double error_p95 = 0;
  double error_max = 0;
  int kept = 0;  ///< scenes whose error is within the dataset's bound
  double bound = 0.25;
  // Of "auto" alone.
  int promised = 0;        ///< scenes whose estimate is within the bound
  int promised_kept = 0;   ///< those of `promised` whose error is within the bound as well
  double tightness = 0;    ///< median of estimate over error
  std::vector<int> sizes;  ///< scenes by points of the border equation, see fidelity_sizes
};

/// Upper ends of the classes of `sizes`; the last class has none.
inline constexpr int fidelity_sizes[] = {16, 32, 64, 128, 256, 512};

}  // namespace ertbench
