#include "limit/limit_probe.h"

#include <nlohmann/json.hpp>

#include "core/json.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_model.h"
#include "limit/frame_limit.h"
#include "limit/posterior_sampler.h"

namespace ertbench {
namespace {

using nlohmann::json;

/// Limits of the first frames of a set under its own prior.
void add_limits(const json& set, SamplerKind kind, Probe& probe) {
  const DatasetSpec spec = dataset_spec_from_json(JsonObject(set, "limit", ""), Sensor{}, "probe");
  const ScenePrior prior(std::get<SceneDistribution>(spec.scenes), spec.sensor.sheet);
  const auto voltages = voltages_for(spec);
  const PosteriorSampler sampler(spec, prior, *voltages, kind, 1);
  const DatasetBlock block =
      generate_block(spec, SceneModel(spec.sensor, spec.model), 0, spec.count);
  std::vector<double> values;
  for (Eigen::Index i = 0; i < block.voltages.rows(); ++i) {
    RandomStream random(key_of("limit probe"), 1, static_cast<std::uint64_t>(i), Purpose::scene);
    const SampledPosterior found =
        sampler.sample(block.voltages.row(i).transpose(), 1, nullptr, random);
    const FrameTruth truth{block.truths[static_cast<std::size_t>(i)], block.conductivity.row(i)};
    const FrameLimit limit =
        limit_of_frame(spec.sensor, spec.rasterisation, truth, found.samples, 0.5);
    for (const auto& [name, value] : limit.metrics) {
      values.insert(values.end(), {value.error.value_or(0), value.expected.value_or(0)});
    }
    values.insert(values.end(), limit.ranks.begin(), limit.ranks.end());
  }
  probe.add(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
}

Probe computed() {
  json set = {
      {"count", 2},
      {"grid", 24},
      {"rasterisation", "centre"},
      {"snr_db", 50},
      {"snr_basis", "absolute"},
      {"scenes",
       {{"contacts", 1}, {"shapes", {"disc"}}, {"radius", 0.2}, {"conductivity_ratio", 0.6}}}};
  Probe probe;
  // A step of a sampler that is taken or not is decided by a comparison, which last digits sway.
  probe.tolerance = Probe::stopped_early;
  add_limits(set, SamplerKind::enumeration, probe);
  set["grid"] = "auto";
  set.erase("rasterisation");
  set["scenes"]["radius"] = {0.15, 0.3};
  add_limits(set, SamplerKind::importance, probe);
  return probe;
}

}  // namespace

Probe limit_probe() { return cached_probe("limit", computed); }

}  // namespace ertbench
