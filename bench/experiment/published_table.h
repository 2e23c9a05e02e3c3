#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/score/metrics.h"

namespace ertbench {

/// A published result to stand beside the row of the same label.
struct PublishedRow {
  std::string label;
  PerMetric<std::optional<double>> values;
};

/// "published" of an experiment file.
struct PublishedTable {
  std::string source;                 ///< "Zheng et al., Table C1"
  std::vector<PublishedRow> rows;     ///< lengths in half sides, whatever the file has them in
  std::vector<std::string> datasets;  ///< the test sets it is compared with; empty: all
};

}  // namespace ertbench
