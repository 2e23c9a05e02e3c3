#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "solvers/channel_mask.h"
#include "solvers/parameter_choice.h"
#include "solvers/solver.h"
#include "solvers/solver_info.h"
#include "solvers/total_variation/interior_point.h"

namespace ertbench {

/// Total variation regularisation by a primal-dual interior point method:
///
///     min over images x of 1/2 |J x - changes|^2 + alpha |A x|_1,
///
/// with J at the uniform background and A the differences across pixel edges times the edges'
/// length, so that |A x|_1 approximates the (anisotropic) total variation. See InteriorPoint.
class Pdipm final : public Solver {
 public:
  static constexpr const char* type = "pdipm";

  /// `{"alpha": > 0 | "auto", "tolerance": 1e-8 ... 0.1, "max_iterations": 1 ... 1000}`.
  /// The default tolerance, 1e-4, leaves the image within about 0.3 % (at most 1 %) of the
  /// optimum, two orders below the error due to noise. Also the key of ChannelMask.
  explicit Pdipm(JsonObject parameters);

  nlohmann::json parameters() const override;
  void check(const Sensor& sensor) const override { mask_.check(sensor); }
  void fit(const FitInput& input) override;
  void reconstruct(FramesView changes, ImagesView images,
                   std::span<FrameReport> reports) const override;
  MaskedChannels masked_channels() const override { return mask_; }
  /// Saves the parameters only; `load` computes the rest from the sensor in a fraction of a second.
  void save(const std::filesystem::path& file) const override;
  void load(const std::filesystem::path& file, const Sensor& sensor) override;

 private:
  void read(JsonObject parameters);
  void set_sensor(const Sensor& sensor);
  void choose_alpha(const FitInput& input);

  Tunable alpha_;
  InteriorPointOptions options_;
  ChannelMask mask_;
  Sensor sensor_;
  std::unique_ptr<const TotalVariation> problem_;
  mutable std::mutex idle_mutex_;
  /// Pool of iterations; a call takes one and returns it with its memory.
  mutable std::vector<std::unique_ptr<InteriorPoint>> idle_;
};

/// The solvers of this room, for the registry.
std::vector<SolverType> total_variation_solvers();

}  // namespace ertbench
