#pragma once

#include <optional>
#include <string>

#include "core/arrays.h"
#include "core/random.h"

namespace ertbench {

/// White Gaussian noise of a set strength: SNR(dB) = 20 log10(|signal| / |noise|), exactly, frame
/// by frame. The signal is the frame itself (`absolute`, EIDORS's add_noise) or its change from the
/// reference voltages (`difference`).
enum class SnrBasis { absolute, difference };

struct Noise {
  std::optional<double> snr_db;  ///< none: no noise
  SnrBasis basis = SnrBasis::absolute;
};

/// Adds noise to one frame [channels] in place. `reference` [channels]. With the difference basis a
/// frame that equals the reference stays as it is: its signal is zero, and so is its noise.
void add_noise(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
               RandomStream& random, Eigen::Ref<Eigen::VectorXd> frame);

/// The 2-norm of the noise on a frame of these clean voltages, V. A set without noise has none to
/// compare with: there the noise of 80 dB (absolute) stands in.
double noise_norm(const Noise& noise, const Eigen::Ref<const Eigen::VectorXd>& reference,
                  const Eigen::Ref<const Eigen::VectorXd>& frame);

const char* name_of(SnrBasis basis);

}  // namespace ertbench
