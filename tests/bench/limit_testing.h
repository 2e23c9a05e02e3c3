#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "forward/sheet/sheet_shapes.h"
#include "limit/scene_likelihood.h"
#include "limit/scene_prior.h"

namespace ertbench::testing {

/// Distance of Kolmogorov and Smirnov between values and a uniform distribution over 0 ... 1.
inline double distance_from_uniform(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  double most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    most = std::max(most, std::abs(values[i] - (static_cast<double>(i) + 0.5) /
                                                   static_cast<double>(values.size())));
  }
  return most;
}

/// A likelihood of a scene's first quantities alone.
class KnownLikelihood : public SceneLikelihood {
 public:
  explicit KnownLikelihood(std::function<double(const Scene&)> log) : log_(std::move(log)) {}
  std::vector<SceneFit> of(std::span<const Scene> scenes,
                           std::span<const double> = {}) const override {
    std::vector<SceneFit> fits;
    for (const Scene& scene : scenes) fits.push_back({log_(scene), 0, 0, {}});
    return fits;
  }

 private:
  std::function<double(const Scene&)> log_;
};

/// One disc of radius 0.2, whose place is open.
inline ScenePrior prior_of_a_disc() {
  SceneDistribution scenes;
  scenes.contacts = {1, 1};
  scenes.shapes = {DrawnShape::disc};
  scenes.radius = {0.2, 0.2};
  return {scenes, square_sheet()};
}

}  // namespace ertbench::testing
