#include "bench/limit/enumerated_discs.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <string>
#include <unordered_map>

#include "bench/limit/disc_importance.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

constexpr double smallest_part = 1e-9;  ///< of the posterior
constexpr std::size_t most_places_of_image = 24;

}  // namespace

bool is_enumerable(const ScenePrior& prior, const SceneVoltages& voltages) {
  return is_one_disc(prior) && !prior.size_is_free() && !prior.ratio_is_free() &&
         !voltages.is_smooth();
}

EnumeratedDiscs::EnumeratedDiscs(const ScenePrior& prior, const Sensor& sensor,
                                 const SceneVoltages& voltages, int side, int lattice,
                                 int threads) {
  const SceneDistribution& d = prior.distribution();
  disc_.size = d.radius.first;
  disc_.conductivity_ratio = d.conductivity_ratio.first;
  const PixelGrid pixels = sensor.sheet->pixels(side);
  const Eigen::Vector2d step = pixels.pixel() / lattice;
  const double margin = d.inside ? disc_.size : 0;
  Eigen::VectorXd ratio(pixels.count());
  std::string key(static_cast<std::size_t>(pixels.count()), ' ');
  std::unordered_map<std::string, std::size_t> known;
  std::vector<Scene> scenes;
  // The middles of the lattice's cells, so that no place is on a border between two images.
  for (int row = 0; row < side * lattice; ++row) {
    for (int column = 0; column < side * lattice; ++column) {
      const Eigen::Vector2d place =
          pixels.corner(0, 0) + step.cwiseProduct(Eigen::Vector2d(column + 0.5, row + 0.5));
      if (sensor.sheet->depth(place) < margin) continue;
      disc_.centre = place;
      const Scene scene = scene_of({disc_});
      rasterise(scene, pixels, Rasterisation::centre, ratio);
      for (Eigen::Index p = 0; p < ratio.size(); ++p) {
        key[static_cast<std::size_t>(p)] = ratio[p] == 1 ? '0' : '1';
      }
      const auto [at, is_new] = known.emplace(key, places_.size());
      if (is_new) {
        places_.emplace_back();
        scenes.push_back(scene);
      }
      places_[at->second].push_back(place);
    }
  }
  voltages_.resize(static_cast<Eigen::Index>(scenes.size()), sensor.channels());
  std::vector<std::future<void>> workers;
  const auto parts = static_cast<std::size_t>(std::max(1, threads));
  for (std::size_t t = 0; t < parts; ++t) {
    const std::size_t begin = scenes.size() * t / parts;
    const std::size_t end = scenes.size() * (t + 1) / parts;
    workers.push_back(std::async(std::launch::async, [&, begin, end] {
      voltages.solve(std::span(scenes).subspan(begin, end - begin), nullptr,
                     voltages_.middleRows(static_cast<Eigen::Index>(begin),
                                          static_cast<Eigen::Index>(end - begin)));
    }));
  }
  for (std::future<void>& worker : workers) worker.get();
}

PosteriorSamples EnumeratedDiscs::posterior(const FrameLikelihood& likelihood) const {
  const std::vector<SceneFit> fits = likelihood.of_voltages(voltages_);
  double best = -1e300;
  for (const SceneFit& fit : fits) best = std::max(best, fit.log_likelihood);
  PosteriorSamples out;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const std::vector<Eigen::Vector2d>& places = places_[i];
    const double weight =
        std::exp(fits[i].log_likelihood - best) * static_cast<double>(places.size());
    if (weight < smallest_part) continue;
    const std::size_t stride = (places.size() + most_places_of_image - 1) / most_places_of_image;
    const std::size_t taken = (places.size() + stride - 1) / stride;
    for (std::size_t p = 0; p < places.size(); p += stride) {
      ContactDraw disc = disc_;
      disc.centre = places[p];
      out.samples.push_back({{disc}, fits[i], weight / static_cast<double>(taken), 0});
    }
  }
  return out;
}

}  // namespace ertbench
