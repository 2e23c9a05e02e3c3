#pragma once

#include <filesystem>
#include <optional>

#include "forward/data/dataset_file.h"
#include "forward/data/generate.h"
#include "forward/fem/forward_model.h"
#include "solvers/channel_mask.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench::testing {

/// A validation set of random contacts, one frame in twenty blank, and the input of a fit with it.
class ValidationFile {
 public:
  explicit ValidationFile(std::uint64_t count = 400) : set_(write(count)) {}

  FitInput input() const {
    FitInput input;
    input.validation = &set_;
    return input;
  }

 private:
  DatasetFile write(std::uint64_t count) const {
    generate_dataset(random_contacts(count, {}, 0.05), folder_ / "validation.h5");
    return DatasetFile(folder_ / "validation.h5");
  }

  TemporaryFolder folder_;
  DatasetFile set_;
};

/// Changes of frames like those of ValidationFile, but other ones; `snr_db` absolute. Without a
/// `seed` scenes are drawn by that of the file.
inline Frames fresh_changes(std::uint64_t count, double snr_db = 50,
                            std::optional<std::uint64_t> seed = {}) {
  DatasetSpec spec = random_contacts(count, {}, 0.05);
  spec.name = "fresh";
  if (seed) spec.seed = *seed;
  spec.noise.snr_db = snr_db;
  const SceneModel model(Sensor{}, GridSheet{24});
  return generate_block(spec, model, 0, count).voltages.rowwise() -
         model.reference_voltages().transpose();
}

/// Calls `change(value, reference voltage)` for every channel that uses one of `dead`.
template <typename Change>
void for_dead_channels(Eigen::Ref<Eigen::RowVectorXd> frame, ElectrodeSet dead, Change&& change) {
  static const Eigen::VectorXd reference = ForwardModel(Sensor{}, 24).reference_voltages();
  const auto electrodes = electrodes_of_pairs(Sensor{});
  const auto pairs = reciprocal_pairs(Sensor{});
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    if (!(electrodes[p] & dead)) continue;
    for (const int channel : pairs[p]) change(frame[channel], reference[channel]);
  }
}

/// Channels of dead electrodes read zero.
inline void read_zero(Eigen::Ref<Eigen::RowVectorXd> frame, ElectrodeSet dead) {
  for_dead_channels(frame, dead, [](double& change, double reference) { change = -reference; });
}

/// Channels of dead electrodes read noise as large as the voltages.
inline void read_noise(Eigen::Ref<Eigen::RowVectorXd> frame, ElectrodeSet dead,
                       RandomStream& random) {
  static const double size = std::sqrt(
      ForwardModel(Sensor{}, 24).reference_voltages().squaredNorm() / Sensor{}.channels());
  for_dead_channels(frame, dead, [&](double& change, double reference) {
    change = size * random.normal() - reference;
  });
}

/// `count` electrodes out of 16.
inline ElectrodeSet random_electrodes(int count, RandomStream& random) {
  ElectrodeSet out = 0;
  while (size_of(out) < count) out |= ElectrodeSet{1} << random.integer(0, 15);
  return out;
}

}  // namespace ertbench::testing
