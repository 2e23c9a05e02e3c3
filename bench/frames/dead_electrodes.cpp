#include "bench/frames/dead_electrodes.h"

#include <cmath>

namespace ertbench {

std::vector<int> electrodes_with_bad_channels(const Sensor& sensor,
                                              const std::function<bool(Eigen::Index)>& is_bad) {
  constexpr double nearly_all = 0.8;
  const auto drives = drive_pairs(sensor);
  const auto measured = measurement_pairs(sensor);
  const std::vector<Channel> channels = channels_of(sensor);
  const auto electrodes = static_cast<std::size_t>(sensor.electrode_count);
  std::vector<int> used(electrodes, 0);
  std::vector<int> bad(electrodes, 0);
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const bool channel_is_bad = is_bad(static_cast<Eigen::Index>(c));
    for (const auto& pair : {drives[static_cast<std::size_t>(channels[c].drive)],
                             measured[static_cast<std::size_t>(channels[c].measurement)]}) {
      for (const int e : {pair.first, pair.second}) {
        ++used[static_cast<std::size_t>(e)];
        bad[static_cast<std::size_t>(e)] += channel_is_bad;
      }
    }
  }
  std::vector<int> out;
  for (std::size_t e = 0; e < electrodes; ++e) {
    if (used[e] > 0 && bad[e] >= nearly_all * used[e]) out.push_back(static_cast<int>(e));
  }
  return out;
}

std::vector<int> electrodes_reading_zero(const Sensor& sensor, const Eigen::VectorXd& reference,
                                         const Eigen::VectorXd& expected) {
  constexpr double nearly_zero = 0.1;
  return electrodes_with_bad_channels(sensor, [&](Eigen::Index c) {
    return std::abs(reference[c]) < nearly_zero * std::abs(expected[c]);
  });
}

}  // namespace ertbench
