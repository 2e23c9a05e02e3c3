#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment.h"

namespace ertbench {

/// One model of the sheet on some scenes of one distribution.
struct FidelityRow {
  std::string dataset;
  std::string scenes;   ///< "smooth", "other" or "all"
  std::string model;    ///< "auto", or the grid's side
  int count = 0;        ///< scenes, blank ones left out: every model is exact there
  double time_us = 0;   ///< a scene, one thread, with whatever rasterising the model needs: median
  double time_low = 0;  ///< 5 and 95 % of the blocks of scenes that are timed as one
  double time_high = 0;
  double error_median = 0;  ///< of the voltage changes, 2-norm, in units of the frame's noise
  double error_p95 = 0;
  double error_max = 0;
  int kept = 0;  ///< scenes whose error is within the dataset's bound
  double bound = 0.25;
  // Of "auto" alone.
  int promised = 0;        ///< scenes whose estimate is within the bound
  int promised_kept = 0;   ///< of these the ones whose error is too
  double tightness = 0;    ///< median of estimate over error
  std::vector<int> sizes;  ///< scenes by points of the border equation, see fidelity_sizes
};

/// Upper ends of the classes of `sizes`; the last class has none.
inline constexpr int fidelity_sizes[] = {16, 32, 64, 128, 256, 512};

struct FidelityOptions {
  std::filesystem::path out;
  int scenes = 500;  ///< of each distribution
};

/// Draws the scenes of every dataset and computes them with "grid": "auto" and with the grids of
/// 24, 48, 96 and 192, in turn, block by block, on one thread. Errors are against the border
/// integral equation at a thousandth of the bound. "smooth" are scenes of whole discs and ellipses
/// that do not touch; "other" those with corners, overlaps, or contacts cut by the sheet's border.
std::vector<FidelityRow> measure_fidelity(const Experiment& experiment, int scenes);

/// fidelity.csv, fidelity.md, fidelity.svg and .png, with provenance, in the folder.
void run_fidelity(const Experiment& experiment, const FidelityOptions& options);

/// Error against time a scene, a panel for each dataset, above the sizes of the systems.
void draw_fidelity_chart(const std::vector<FidelityRow>& rows, const std::string& title,
                         const std::filesystem::path& stem);

}  // namespace ertbench
