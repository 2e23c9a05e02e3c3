#pragma once

#include <optional>
#include <vector>

#include "bench/limit/annealed_sampler.h"

namespace ertbench {

/// All images that a disc of one size and conductivity can have where pixels are filled by their
/// centres, each with its places and its voltages. The posterior over them is a sum: no sampling,
/// no derivatives, which there are none of.
class EnumeratedDiscs {
 public:
  /// `voltages` by the centres of pixels on a grid of `side`. Places stand on a lattice of
  /// `lattice` points a pixel, in x and in y.
  EnumeratedDiscs(const ScenePrior& prior, const Sensor& sensor, const SceneVoltages& voltages,
                  int side, int lattice, int threads);

  std::size_t images() const { return places_.size(); }

  /// The places of all images with a part in the posterior, with their weights. Those of one image
  /// share its weight out.
  PosteriorSamples posterior(const FrameLikelihood& likelihood) const;

 private:
  ContactDraw disc_;
  std::vector<std::vector<Eigen::Vector2d>> places_;  ///< [images]
  Frames voltages_;                                   ///< [images, channels] V
};

/// Whether such a posterior may be had: one disc, of which the place alone is free.
bool is_enumerable(const ScenePrior& prior, const SceneVoltages& voltages);

}  // namespace ertbench
