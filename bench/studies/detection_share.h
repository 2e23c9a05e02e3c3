#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/studies/error_statistics.h"

/// Whether something succeeded, against a quantity that it grows with: detection against force.
namespace ertbench {

/// A share of which so many were counted, with Wilson's interval; nothing of none.
struct CountedShare {
  int count = 0;
  int total = 0;

  void add(bool counted) {
    count += counted;
    ++total;
  }
  std::optional<Estimate> share() const;
};

struct Trial {
  double value = 0;  ///< what success grows with
  bool success = false;
  std::size_t group = 0;  ///< trials of a group are drawn together: the frames of a scene
};

/// Trials that follow each other in their values.
struct ShareBin {
  double low = 0;   ///< the least value
  double high = 0;  ///< the largest
  double mean = 0;
  CountedShare successes;
};

/// So many bins of equally many trials, those of the least values first; fewer, so that each has
/// `least_trials`.
std::vector<ShareBin> share_bins(std::vector<Trial> trials, int bins, int least_trials = 20);

/// From which value on the share of successes reaches what was asked for.
struct LeastFound {
  double value = 0;
  Interval ci95;  ///< by the bootstrap over groups
  /// From the mean of the twenty least values, where a value stands for "here or before", to the
  /// largest, beyond which a value stands for "nowhere".
  Interval reach;
};

/// By isotonic regression (pool adjacent violators, Ayer et al. 1955) of the success on the value,
/// in bins of twenty trials, as one in twenty is the least that a share of 95 % can tell, with
/// straight lines between the bins. Nothing of fewer than two bins.
std::optional<LeastFound> least_found(std::vector<Trial> trials, double share,
                                      const std::string& name);

}  // namespace ertbench
