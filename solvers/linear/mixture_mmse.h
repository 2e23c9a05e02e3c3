#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "solvers/channel_mask.h"
#include "solvers/linear/mixture.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/tunable.h"

namespace ertbench {

/// The minimum-mean-square-error image under a mixture of Gaussians fitted to the training scenes,
/// type "lmmse" with several components: each covers contacts of about one place and strength, and
/// has a linear estimate of its own; a frame's image is their mean, weighted by the posterior
/// probabilities of the components. A frame costs the probabilities of all components (24 x 24
/// numbers each) and the matrices of the two or three that have any. All in single precision.
///
/// Dead electrodes are left out of all the Gaussians, which is exact but for the choice of the
/// directions; what that takes is kept for the sets of electrodes met last.
class MixtureMmse final : public Solver {
 public:
  static constexpr const char* type = "lmmse";

  /// `{"components": 2 ... 1024, "ridge": > 0 | "auto", "symmetries": bool}` and what ChannelMask
  /// reads.
  explicit MixtureMmse(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override { mask_.check(sensor); }
  bool needs_training() const override { return true; }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  void read(JsonObject parameters);
  void set_sensor(const Sensor& sensor);
  void set_mean();
  /// Without the channels of these electrodes, besides those masked in every frame; null where none
  /// is left.
  std::shared_ptr<const MixtureMean> mean_without(ElectrodeSet dead) const;

  int components_ = 2;
  bool symmetries_ = true;
  Tunable ridge_;
  std::optional<ParameterChoice> choice_;
  ChannelMask mask_;
  Sensor sensor_;
  Reciprocity reciprocity_;
  GaussianMixture mixture_;
  std::shared_ptr<const MixtureMean> mean_;
  mutable std::mutex masked_mutex_;
  mutable std::map<ElectrodeSet, std::shared_ptr<const MixtureMean>> masked_;
};

}  // namespace ertbench
