#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/experiment/experiment.h"
#include "bench/limit/frame_limit.h"
#include "bench/limit/posterior_sampler.h"

namespace ertbench {

struct LimitOptions {
  std::vector<std::string> datasets;  ///< test sets; none: all
  int frames = 100;                   ///< of each set, the first
  int threads = 1;
  SamplerKind sampler = SamplerKind::automatic;
  bool fair = true;  ///< also under the training set's distribution, which may take far longer
  std::filesystem::path
      records;  ///< folder of the frames' records, which a later call goes on from
};

/// The limits of a set's frames under one prior: "oracle", the distribution of its own scenes, or
/// "fair", that of the training set.
struct SetLimit {
  std::string dataset;
  std::string prior;
  std::string model;  ///< of the likelihood: SceneVoltages::name
  std::string key;    ///< limit_key() of the set
  std::vector<FrameLimit> frames;
};

/// Computes what is missing, writes each frame's record when it is finished (into another file,
/// renamed), and reads the others. Progress goes to standard error. Throws InputError for sets that
/// have no limit: touches, sequences, lists of scenes, faults, no noise.
std::vector<SetLimit> compute_limits(const Experiment& experiment, const LimitOptions& options);

/// Why a set has no limit; empty where it has.
std::string why_no_limit(const DatasetSpec& spec);

}  // namespace ertbench
