#pragma once

#include <cstdint>
#include <vector>

#include "bench/ktc2023/ktc_files.h"

namespace ertbench {

/// Targets of one to five plastic or metal cylinders, of round and polygonal section, anywhere in
/// the calibrated tank. Their changes are those of finer finite elements, with 1 % and 1 mV per mA
/// of noise, on top of the reference's voltages. They stand for every level. Throws InputError
/// where the reference lacks channels.
std::vector<KtcTarget> simulate_ktc_targets(const KtcReference& reference,
                                            const std::filesystem::path& reference_file,
                                            const KtcCalibration& calibration, int count,
                                            std::uint64_t seed);

}  // namespace ertbench
