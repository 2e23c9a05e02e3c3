#pragma once

#include <string>
#include <vector>

#include "core/arrays.h"

namespace ertbench {

/// How the columns of a file become the channels of a sensor: each is a column, or the difference
/// of two (where columns are potentials), times a factor (a unit, a sign).
struct ChannelMap {
  struct Entry {
    Eigen::Index plus = 0;
    Eigen::Index minus = -1;  ///< none
    double factor = 1;        ///< to V
  };

  std::string order;           ///< as it was declared: "drive-major", a file's name
  Eigen::Index columns = 0;    ///< that a file with this order has
  std::vector<Entry> entries;  ///< [channels]

  /// `table` [rows, columns], in the file's unit, to frames [rows, channels] V.
  Frames apply(const RowMajorMatrix& table) const;
  /// The map that makes frames of this one's into others: channel c becomes `factor[c]` times what
  /// channel `from[c]` was.
  ChannelMap mended(const std::vector<int>& from, const Eigen::VectorXd& factor) const;
  /// The entries as [channels, 3]: column, the column that is taken from it or -1, factor.
  RowMajorMatrix table() const;
};

}  // namespace ertbench
