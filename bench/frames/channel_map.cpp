#include "bench/frames/channel_map.h"

namespace ertbench {

Frames ChannelMap::apply(const RowMajorMatrix& table) const {
  Frames frames(table.rows(), static_cast<Eigen::Index>(entries.size()));
  for (Eigen::Index row = 0; row < table.rows(); ++row) {
    for (std::size_t c = 0; c < entries.size(); ++c) {
      const Entry& entry = entries[c];
      double value = table(row, entry.plus);
      if (entry.minus >= 0) value -= table(row, entry.minus);
      frames(row, static_cast<Eigen::Index>(c)) = entry.factor * value;
    }
  }
  return frames;
}

ChannelMap ChannelMap::mended(const std::vector<int>& from, const Eigen::VectorXd& factor) const {
  ChannelMap out{order, columns, {}};
  for (std::size_t c = 0; c < from.size(); ++c) {
    Entry entry = entries[static_cast<std::size_t>(from[c])];
    entry.factor *= factor[static_cast<Eigen::Index>(c)];
    out.entries.push_back(entry);
  }
  return out;
}

RowMajorMatrix ChannelMap::table() const {
  RowMajorMatrix out(static_cast<Eigen::Index>(entries.size()), 3);
  for (std::size_t c = 0; c < entries.size(); ++c) {
    out.row(static_cast<Eigen::Index>(c)) << static_cast<double>(entries[c].plus),
        static_cast<double>(entries[c].minus), entries[c].factor;
  }
  return out;
}

}  // namespace ertbench
