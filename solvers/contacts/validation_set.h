#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "forward/data/dataset_file.h"
#include "solvers/solver.h"

namespace ertbench {

/// Frames of a validation set that noise and misfits are taken from, the first.
inline constexpr std::uint64_t judged_frames = 400;

/// Standard deviation of one channel, V, from what the two channels of a reciprocal pair differ by,
/// pairs of the `masked` electrodes left out; of simulated frames without such pairs from their
/// clean voltages. Nothing where no frame tells: measured ones whose channels are all different.
std::optional<double> noise_of_channel(const DatasetFile& set, ElectrodeSet masked);

/// Of the first `count` frames those whose contacts all have a conductivity ratio in `ratio`, or
/// all where few do or none is given: what another contact leaves when it is fitted as one of this
/// ratio says nothing of a frame.
std::vector<Eigen::Index> frames_like(const DatasetFile& set, std::uint64_t count,
                                      const std::optional<std::pair<double, double>>& ratio);

}  // namespace ertbench
