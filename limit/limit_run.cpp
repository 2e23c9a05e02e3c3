#include "limit/limit_run.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <nlohmann/json.hpp>
#include <utility>

#include "bench/record/limit_file.h"
#include "bench/record/record_file.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/process.h"
#include "core/seconds.h"
#include "core/text.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_model.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int limit_version = 7;        ///< version of the records' content
constexpr std::array efforts = {1, 2};  ///< the second is tried if the first was not enough
/// The chains of a lower bound. They start at the frame's own scene.
constexpr AnnealingOptions chains = {
    .islands = 1, .particles = 4, .final_rounds = 6000, .snapshots = 100};
constexpr const char* lower = "lower";

/// Everything but the code that determines a frame's record. `broad`: the prior whose samples are
/// reweighted if possible, or null.
std::string key_of_record(const DatasetSpec& spec, const ScenePrior& prior, const ScenePrior* broad,
                          const std::string& model, const std::string& sampler) {
  json set = to_json(spec);
  set.erase("count");
  const json key = {{"version", limit_version},
                    {"set", set},
                    {"prior", to_json(prior.distribution())},
                    {"broad", broad ? to_json(broad->distribution()) : nullptr},
                    {"model", model},
                    {"sampler", sampler}};
  return key.dump();
}

/// The records of one set and prior.
class Records {
 public:
  Records(fs::path folder, std::string key, BuildStamp build)
      : folder_(std::move(folder)), key_(std::move(key)), build_(std::move(build)) {}

  std::optional<FrameLimit> read(std::uint64_t frame) const {
    const fs::path file = file_of(frame);
    const FoundRecord found = find_record(file, key_, build_, Reuse::same_code);
    if (found.record->is_null()) {
      if (!found.why_not.empty()) {
        spdlog::info("{}: computed again: {}", file.string(), found.why_not);
      }
      return std::nullopt;
    }
    JsonObject record(*found.record, file.string(), "");
    FrameLimit limit = frame_limit_from_json(record.object("limit"));
    limit.build = *build_stamp_from_json(record.raw("build"));
    return limit;
  }

  void write(FrameLimit& limit) const {
    limit.build = build_;
    write_record(file_of(limit.frame), {{"limit", to_json(limit)}}, key_, build_);
  }

 private:
  fs::path file_of(std::uint64_t frame) const { return folder_ / fmt::format("{:06}.json", frame); }

  fs::path folder_;
  std::string key_;
  BuildStamp build_;
};

/// The frames of a set under one prior.
struct Task {
  std::string name;  ///< "oracle", "fair", "lower"
  ScenePrior prior;
  Records records;
  std::vector<std::optional<FrameLimit>> frames;

  bool wants(std::size_t frame) const { return !frames[frame]; }
};

/// One test set under its priors.
class SetRun {
 public:
  SetRun(const DatasetSpec& spec, const DatasetSpec* training, const LimitOptions& options)
      : spec_(spec), training_(training), options_(options), voltages_(voltages_for(spec)) {
    const auto count = static_cast<std::size_t>(
        std::min<std::uint64_t>(spec.count, static_cast<std::uint64_t>(options.frames)));
    const auto add = [&](const std::string& name, const ScenePrior& prior,
                         const ScenePrior* broad) {
      const std::string& sampler = names_of_samplers()[static_cast<std::size_t>(options.sampler)];
      const std::string key = key_of_record(
          spec, prior, broad, model_name(spec, *voltages_),
          name != lower
              ? sampler
              : lower + std::to_string(chains.particles * chains.final_rounds) + " with splits");
      const fs::path folder = options.records / (spec.name + "_" + name);
      fs::create_directories(folder);
      const DatasetSpec& scenes = name == "fair" ? *training : spec;
      tasks_.push_back({name, prior, Records(folder, key, stamp_of_limit(spec, scenes)), {}});
      for (std::size_t i = 0; i < count; ++i)
        tasks_.back().frames.push_back(tasks_.back().records.read(i));
    };
    const auto& own = std::get<SceneDistribution>(spec.scenes);
    const ScenePrior oracle(own, spec.sensor.sheet);
    if (options.lower) {
      if (own.contacts.first == 0 || own.blank_fraction > 0) {
        throw InputError("--lower: \"" + spec.name +
                         "\" has scenes without contact, whose relative error is undefined; name "
                         "other sets by --dataset");
      }
      add(lower, oracle, nullptr);
      return;
    }
    const auto* taught = training ? std::get_if<SceneDistribution>(&training->scenes) : nullptr;
    const bool same = taught && to_json(*taught) == to_json(own);
    std::optional<ScenePrior> fair;
    if (options.fair && taught && !same) fair.emplace(*taught, spec.sensor.sheet);
    const auto kind_of = [&](const ScenePrior& prior) {
      return resolved(options.sampler, prior, *voltages_);
    };
    may_reweight_ = fair && kind_of(*fair) == kind_of(oracle);
    add("oracle", oracle, may_reweight_ ? &*fair : nullptr);
    if (fair) add("fair", *fair, nullptr);
    is_fair_too_ = options.fair && same;
  }

  std::vector<SetLimit> run() {
    prepare();
    const std::size_t count = tasks_.front().frames.size();
    const auto missing =
        static_cast<std::uint64_t>(std::ranges::count_if(unfinished_, [](bool b) { return b; }));
    if (missing > 0) {
      Progress progress("limit of \"" + spec_.name + "\" (" + model_name(spec_, *voltages_) + ")");
      std::uint64_t done = 0;
      std::mutex mutex;
      parallel_for(count, 1, options_.threads, [&](std::size_t i, std::size_t) {
        if (!unfinished_[i]) return;
        options_.lower ? compute_lower(i) : compute(i);
        const std::lock_guard lock(mutex);
        progress.update(++done, missing);
      });
    }
    std::vector<SetLimit> out;
    for (const Task& task : tasks_) {
      const DatasetSpec& scenes = task.name == "fair" ? *training_ : spec_;
      out.push_back(
          {spec_.name, task.name, model_name(spec_, *voltages_), limit_key(spec_, scenes), {}});
      for (const std::optional<FrameLimit>& frame : task.frames) {
        out.back().frames.push_back(*frame);
        if (!options_.lower) judge(spec_.sensor.channels(), out.back().frames.back());
      }
    }
    if (is_fair_too_) {
      out.push_back(out.front());
      out.back().prior = "fair";
    }
    return out;
  }

 private:
  /// Makes the missing frames and the samplers for them.
  void prepare() {
    const std::size_t count = tasks_.front().frames.size();
    unfinished_.assign(count, false);
    for (const Task& task : tasks_) {
      for (std::size_t i = 0; i < count; ++i) unfinished_[i] = unfinished_[i] || task.wants(i);
    }
    if (std::ranges::none_of(unfinished_, [](bool b) { return b; })) return;
    const SceneModel model(spec_.sensor, spec_.model);
    block_ = generate_block(spec_, model, 0, count, options_.threads);
    if (options_.lower) {
      const double noise = noise_norm(spec_.noise, voltages_->reference(), voltages_->reference());
      metric_ = std::make_unique<PlaceMetric>(
          spec_.sensor, std::max(noise, 1e-12 * voltages_->reference().norm()) /
                            std::sqrt(static_cast<double>(spec_.sensor.channels())));
      if (voltages_->is_smooth()) ellipses_ = std::make_unique<EllipseModel>(spec_.sensor);
      return;
    }
    // The broadest prior comes first: its samples may be reweighted for the other.
    for (auto task = tasks_.rbegin(); task != tasks_.rend(); ++task) {
      samplers_.push_back(std::make_unique<PosteriorSampler>(spec_, task->prior, *voltages_,
                                                             options_.sampler, options_.threads));
    }
    std::ranges::reverse(samplers_);
  }

  /// A frame's records do not depend on which of them exist already: if the oracle reweights the
  /// broad prior's samples, these are drawn again for it.
  void compute(std::size_t frame) {
    const int channels = spec_.sensor.channels();
    PosteriorSamples posterior;
    std::optional<FrameLimit> broad;
    for (std::size_t t = tasks_.size(); t-- > 0;) {
      Task& task = tasks_[t];
      const bool serves = t > 0 && may_reweight_ && tasks_[t - 1].wants(frame);
      if (!task.wants(frame) && !serves) continue;
      const auto start = SteadyClock::now();
      std::optional<FrameLimit> limit;
      if (broad && may_reweight_ && reweight(tasks_[t + 1].prior, task.prior, posterior)) {
        limit = judged(frame, t, posterior);
        limit->solves = 0;
        // Sample anew if only the reweighting left too few effective samples.
        if (deserves_more(channels, *limit) && !deserves_more(channels, *broad)) limit.reset();
      }
      if (!limit) {
        posterior = {};
        limit = sampled(frame, t, posterior);
        limit->solves = posterior.solves;
      }
      limit->seconds = seconds_since(start);
      broad = limit;
      if (!task.wants(frame)) continue;
      task.records.write(*limit);
      task.frames[frame] = limit;
    }
  }

  /// Chains from the scene of a frame. Its voltages are made anew by the chains' own model, with
  /// the Gaussian noise of the likelihood, so that the scene is a draw from their posterior.
  void compute_lower(std::size_t frame) {
    const auto start = SteadyClock::now();
    const ScenePrior& prior = tasks_.front().prior;
    RandomStream scenes = spec_.stream(spec_.scene_number(frame), Purpose::scene);
    const SceneDraw drawn = prior.draw(scenes);
    const FrameTruth truth{scene_of(drawn),
                           block_.conductivity.row(static_cast<Eigen::Index>(frame))};
    RandomStream random(key_of("limit lower"), key_of(spec_.name), frame, Purpose::scene);
    const FrameLikelihood given(*voltages_, spec_.noise,
                                block_.voltages.row(static_cast<Eigen::Index>(frame)).transpose());
    Eigen::VectorXd voltages = given.voltages_of({&truth.scene, 1}).row(0);
    const double noise = given.channel_noise(voltages);
    for (double& value : voltages) value += noise * random.normal();
    const FrameLikelihood likelihood(*voltages_, spec_.noise, voltages);
    std::optional<JointStep> joint;
    if (ellipses_) joint.emplace(prior, *ellipses_);
    AnnealingIsland island(prior, likelihood, *metric_, joint ? &*joint : nullptr, chains, random);
    PosteriorSamples found;
    island.run_chains(drawn, found.samples);
    FrameLimit limit = lower_bound_of_frame(spec_.sensor, spec_.rasterisation, truth, found);
    limit.frame = frame;
    limit.solves = island.solves();
    limit.seconds = seconds_since(start);
    tasks_.front().records.write(limit);
    tasks_.front().frames[frame] = limit;
  }

  FrameLimit sampled(std::size_t frame, std::size_t task, PosteriorSamples& posterior) const {
    FrameLimit limit;
    for (const int effort : efforts) {
      RandomStream random(key_of("limit " + tasks_[task].name), key_of(spec_.name),
                          frame * 16 + static_cast<std::uint64_t>(effort), Purpose::scene);
      const auto row = static_cast<Eigen::Index>(frame);
      const PosteriorSamples before = std::exchange(posterior, {});
      posterior = samplers_[task]->sample(block_.voltages.row(row).transpose(), effort,
                                          before.samples.empty() ? nullptr : &before, random);
      limit = judged(frame, task, posterior);
      if (!deserves_more(spec_.sensor.channels(), limit)) break;
    }
    return limit;
  }

  FrameLimit judged(std::size_t frame, std::size_t task, const PosteriorSamples& posterior) const {
    RandomStream ties(key_of("limit ties"), key_of(spec_.name), frame, Purpose::scene);
    const FrameTruth truth{block_.truths[frame],
                           block_.conductivity.row(static_cast<Eigen::Index>(frame))};
    FrameLimit limit =
        limit_of_frame(spec_.sensor, spec_.rasterisation, truth, posterior, ties.uniform());
    limit.frame = frame;
    limit.sampler = samplers_[task]->name();
    limit.pareto_k = posterior.pareto_k;
    judge(spec_.sensor.channels(), limit);
    return limit;
  }

  const DatasetSpec& spec_;
  const DatasetSpec* training_;
  const LimitOptions& options_;
  std::unique_ptr<SceneVoltages> voltages_;
  std::vector<Task> tasks_;
  bool is_fair_too_ = false;
  bool may_reweight_ = false;     ///< samples of the broad prior may be reweighted for the oracle
  std::vector<char> unfinished_;  ///< [frames] missing under some prior
  DatasetBlock block_;
  std::vector<std::unique_ptr<PosteriorSampler>> samplers_;
  std::unique_ptr<PlaceMetric> metric_;     ///< of the chains of a lower bound, as the next
  std::unique_ptr<EllipseModel> ellipses_;  ///< null where voltages are not smooth
};

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
    const PosteriorSamples found =
        sampler.sample(block.voltages.row(i).transpose(), 1, nullptr, random);
    const FrameTruth truth{block.truths[static_cast<std::size_t>(i)], block.conductivity.row(i)};
    const FrameLimit limit = limit_of_frame(spec.sensor, spec.rasterisation, truth, found, 0.5);
    for (const auto& [name, value] : limit.metrics) {
      values.insert(values.end(), {value.error.value_or(0), value.expected.value_or(0)});
    }
    values.insert(values.end(), limit.ranks.begin(), limit.ranks.end());
  }
  probe.add(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
}

Probe computed_probe() {
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

Probe limit_probe() { return cached_probe("limit", computed_probe); }

std::string why_no_limit(const DatasetSpec& spec) {
  if (!std::holds_alternative<SceneDistribution>(spec.scenes)) {
    return "its scenes are no contacts drawn at random";
  }
  if (std::get<SceneDistribution>(spec.scenes).gap) return "its contacts depend on each other";
  if (!spec.noise.snr_db) return "it has no noise";
  if (spec.faults.any()) return "it has faults";
  return "";
}

std::vector<const DatasetSpec*> sets_with_limit(const Experiment& experiment,
                                                const LimitOptions& options) {
  const auto names = distinct(experiment.tests, &DatasetSpec::name);
  for (const std::string& name : options.datasets) {
    if (contains(names, name)) continue;
    throw InputError(experiment.source + ": no test set is called \"" + printable(name) +
                     "\"; there are \"" + joined(names, "\", \"") + "\"");
  }
  std::vector<const DatasetSpec*> sets;
  std::string reasons;
  for (const DatasetSpec& test : experiment.tests) {
    if (!options.datasets.empty() && !contains(options.datasets, test.name)) continue;
    const std::string why = why_no_limit(test);
    if (!why.empty()) {
      reasons += "; \"" + test.name + "\": " + why;
      spdlog::warn("no limit of \"{}\": {}", test.name, why);
      continue;
    }
    sets.push_back(&test);
  }
  if (sets.empty()) throw InputError(experiment.source + ": no test set has a limit" + reasons);
  return sets;
}

std::vector<SetLimit> compute_limits(const Experiment& experiment, const LimitOptions& options) {
  limit_probe();  // from now on in the cache, where stamp_of_limit finds it
  const DatasetSpec* training = experiment.training ? &*experiment.training : nullptr;
  std::vector<SetLimit> out;
  for (const DatasetSpec* test : sets_with_limit(experiment, options)) {
    for (SetLimit& limit : SetRun(*test, training, options).run()) out.push_back(std::move(limit));
  }
  return out;
}

}  // namespace ertbench
