#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/random.h"
#include "forward/data/dataset_spec.h"
#include "limit/scene_likelihood.h"
#include "limit/scene_prior.h"

namespace ertbench {

struct NestedOptions {
  int live = 50;       ///< scenes
  int moves = 40;      ///< of each new scene
  double rest = 1e-3;  ///< share of the evidence that may be left in the scenes at the end
};

/// A log evidence and its standard deviation.
struct Evidence {
  double log = -std::numeric_limits<double>::infinity();
  double deviation = 0;
};

/// Nested sampling (Skilling 2006): again and again the worst of the scenes gives way to a copy of
/// another, moved (SceneMoves) among the scenes of the prior that are better than the one that
/// went. The evidence is the sum of the likelihoods of those that went over the parts of the prior
/// that went with them. It knows no powers of the likelihood, no bank and no joint steps, and so
/// errs otherwise than sample_by_annealing(). Its deviation is that of the sizes of the parts; what
/// a mode that died out or too few moves do is not in it.
///
/// The prior has one number of contacts. `solves` grows by the number of scenes solved.
Evidence nested_evidence(const ScenePrior& prior, const SceneLikelihood& likelihood,
                         const PlaceMetric& metric, const NestedOptions& options,
                         RandomStream& random, std::uint64_t& solves);

/// A frame's evidence by both samplers, and by both the probability of each number of contacts.
struct EvidenceCheck {
  Evidence annealed;  ///< the mean over the islands
  Evidence nested;
  std::vector<double> annealed_numbers;  ///< [0 ... most contacts]
  std::vector<double> nested_numbers;
  std::uint64_t solves = 0;  ///< of nested sampling

  double difference() const { return nested.log - annealed.log; }
  double deviation() const;  ///< of the difference
};

/// The first frames of a set under the prior of its own scenes. They are taken as they are, without
/// the correction by the set's own model.
std::vector<EvidenceCheck> check_evidences(const DatasetSpec& spec, int frames, int threads);

}  // namespace ertbench
