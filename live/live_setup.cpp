#include <spdlog/spdlog.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_solvers.h"
#include "bench/record/cache.h"
#include "bench/run/datasets.h"
#include "bench/score/image_contacts.h"
#include "core/errors.h"
#include "core/files.h"
#include "core/json.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "forward/data/dataset_file.h"
#include "forward/data/scene_model.h"
#include "forward/data/sheet_model.h"
#include "forward/sheet/sensor_json.h"
#include "frames/calibration.h"
#include "frames/reference_check.h"
#include "live/live.h"
#include "live/live_record.h"
#include "solvers/registry/named_solver.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double most_volts = 1000;

/// A fitted solver with its sensor, model and contact rule.
struct ReadySolver {
  std::string name;
  Sensor sensor;
  SheetModel model = ContinuousSheet{};  ///< gives the reference voltages
  std::unique_ptr<Solver> solver;
  decltype(LiveSetup::fit) fit;
  ContactRule rule;
};

SolverEntry& entry_named(Experiment& experiment, const std::string& label) {
  std::string known;
  for (SolverEntry& entry : experiment.solvers) {
    if (entry.label == label || entry.stem() == label) return entry;
    if (!known.ends_with(entry.label)) known.append(known.empty() ? "" : ", ").append(entry.label);
  }
  throw InputError("--solver: " + experiment.source + " has no solver \"" + printable(label) +
                   "\"; it has " + known);
}

ReadySolver solver_of_experiment(const LiveOptions& options, SolverRegistry& registry) {
  Experiment experiment = read_experiment(options.experiment, registry, {}, SolverCheck::none);
  SolverEntry& entry = entry_named(experiment, options.solver);
  registry.allow_plugins();  // this process is there for nothing else
  describe(entry, registry.load(entry.type));
  const FitRecipe recipe = fit_recipe(experiment, entry);
  const Cache cache = Cache::standard();
  const CacheShare share(cache, CacheShare::Of::run);
  const DatasetSpec* chosen_on = experiment.find_dataset(
      experiment.contacts.chosen_on.empty() ? "validation" : experiment.contacts.chosen_on);
  for (const DatasetSpec* set : {recipe.training ? &*recipe.training : nullptr,
                                 recipe.validation ? &*recipe.validation : nullptr, chosen_on}) {
    if (!set) continue;
    fs::create_directories(cache.dataset(*set).parent_path());
    ensure_dataset(*set, cache, options.threads);
  }
  if (!fs::exists(cache.fitted_solver(recipe))) {
    spdlog::info("fitting {}, once; the fit is cached", entry.title());
  }
  const TemporaryFolder folder("live");
  ReadySolver out;
  out.name = entry.title();
  out.sensor = experiment.sensor;
  out.model = experiment.tests.front().model;
  out.solver = fitted_solver(recipe, cache, registry, options.threads, folder / "progress").solver;
  std::optional<DatasetFile> set;
  if (chosen_on) set.emplace(cache.open_dataset(*chosen_on));
  out.rule =
      choose_contact_rule(experiment.contacts, out.sensor, *out.solver, set ? &*set : nullptr).rule;
  return out;
}

ReadySolver solver_of_entry(const LiveOptions& options, const Sensor& sensor,
                            SolverRegistry& registry) {
  registry.allow_plugins();
  const TemporaryFolder folder("live");
  FitInput fit;
  fit.sensor = sensor;
  fit.threads = options.threads;
  fit.work_folder = folder.path();
  NamedSolver named = read_named_solver(options.solver);
  ReadySolver out;
  out.sensor = sensor;
  if (options.background > 1 && named.entry->is_object()) {
    // Until the first frames tell their noise.
    constexpr double usual_noise = 1e-3;
    const NamedSolver given = named;
    const auto complete = [given, sensor](const Eigen::VectorXd& reference, double noise) {
      json entry = *given.entry;
      complete_contacts(entry, sensor, reference, noise);
      return NamedSolver{JsonValue(std::move(entry)), given.source};
    };
    named = complete(uniform_reference(sensor), usual_noise);
    if (*named.entry != *given.entry) {
      out.fit = [=, &registry](const Eigen::VectorXd& reference, double noise) {
        FitInput again;
        again.sensor = sensor;
        again.threads = options.threads;
        return std::shared_ptr<Solver>(fitted_solver(complete(reference, noise), again, registry));
      };
    }
  }
  out.solver = fitted_solver(named, fit, registry);
  out.name = named.entry->value("label", named.entry->at("type").get<std::string>());
  return out;
}

std::optional<FramesOfFile> replayed(const InputPlace& place) {
  if (place.kind != InputPlace::Kind::replay) return std::nullopt;
  return read_frames_of(place.name, "--input");
}

Sensor sensor_for_file(const LiveOptions& options, const std::optional<FramesOfFile>& replay) {
  if (!options.sensor.empty()) {
    return read_sensor(options.sensor);
  }
  if (replay) return replay->sensor.value_or(Sensor{});
  const bool file = !options.reference.empty() && options.reference != "model";
  return file ? read_frames_of(options.reference, "--reference").sensor.value_or(Sensor{})
              : Sensor{};
}

/// The voltages without contact [channels] V; nothing if they are the mean of the first frames.
std::optional<Eigen::RowVectorXd> reference_for(const LiveOptions& options,
                                                const ReadySolver& ready, const ChannelMap& map,
                                                const std::optional<FramesOfFile>& replay) {
  if (options.background > 0) return std::nullopt;
  if (options.reference == "model") {
    return SceneModel(ready.sensor, ready.model).reference_voltages().transpose();
  }
  std::optional<Eigen::RowVectorXd> found;
  if (!options.reference.empty()) {
    found = read_frames_of(options.reference, "--reference").reference;
    if (!found) {
      throw InputError(options.reference + ": has no /reference_voltages [channels] V");
    }
  } else if (replay) {
    found = replay->reference;
  }
  if (!found) {
    throw InputError(
        "the voltages of the untouched skin are not known: give --background N (the "
        "first N frames), --reference FILE.h5 or --reference model");
  }
  if (found->size() != map.columns) {
    throw InputError("--reference: has " + std::to_string(found->size()) +
                     " voltages, a frame of the sensor " + std::to_string(map.columns) +
                     " columns");
  }
  return map.apply(*found);
}

std::unique_ptr<LiveSource> source_for(const LiveOptions& options, const InputPlace& place,
                                       FrameColumns channels, std::optional<FramesOfFile>& replay) {
  using Kind = InputPlace::Kind;
  if (place.kind == Kind::standard_input) return open_standard_input(channels, options.format);
  if (place.kind == Kind::serial) return open_serial(place, channels, options.format);
  if (place.kind == Kind::udp) return open_udp(place, channels, options.format);
  return replay_of(std::move(replay->voltages), channels, options.repeat, place.rate);
}

std::vector<fs::path> files_of(const LiveOptions& options, const InputPlace& place) {
  std::vector<fs::path> out;
  if (place.kind == InputPlace::Kind::replay) out.emplace_back(place.name);
  if (options.reference != "model") out.emplace_back(options.reference);
  out.emplace_back(quiet_file(options.quiet));
  out.emplace_back(options.forces);
  std::erase_if(out, [](const fs::path& file) { return file.empty(); });
  return out;
}

/// Refuses files of other voltages than the model's, which would teach wrong thresholds and forces.
void require_reference(const Sensor& sensor, const Eigen::RowVectorXd& reference,
                       const std::string& option, const LiveOptions& options) {
  if (options.fix) return;  // they are mended with the frames
  settle(check_reference(sensor, reference.transpose(), Frames(0, reference.size())), option, false,
         options.force);
}

}  // namespace

void take_reference(LiveSolver& solver, const Eigen::RowVectorXd& reference,
                    const LiveOptions& options) {
  solver.set_reference(reference);
  if (options.normalised) {
    ReferenceVerdict gains;
    gains.normalise(reference.transpose(), BorderModel(solver.sensor()).reference_voltages());
    solver.mend(gains);
    return;
  }
  const ReferenceVerdict verdict =
      check_reference(solver.sensor(), reference.transpose(), Frames(0, reference.size()));
  const bool sound = verdict.state == ReferenceVerdict::State::sound;
  const bool mends = settle(verdict, "--reference", options.fix, options.force);
  if (mends) solver.mend(verdict);
  solver.set_dead(verdict.dead);
  if (sound && verdict.notes.empty()) return;
  spdlog::warn("{}{}", verdict.text(), mends ? "\n  the frames are read so (--fix)" : "");
}

LiveSetup live_setup(const LiveOptions& options, SolverRegistry& registry) {
  const InputPlace place = input_place(options.input);
  if (!options.plugin.empty()) registry.add_library(options.plugin);
  std::optional<FramesOfFile> replay = replayed(place);
  ReadySolver ready = options.experiment.empty()
                          ? solver_of_entry(options, sensor_for_file(options, replay), registry)
                          : solver_of_experiment(options, registry);
  const Sensor& sensor = ready.sensor;
  LiveSetup out;
  out.map = replay && replay->source
                ? channel_map(sensor, *replay->source, options.channels, options.unit)
                : channel_map(sensor, options.channels, options.unit);
  if (replay) replay->require(sensor, place.name, out.map.columns);
  const std::optional<Eigen::RowVectorXd> reference =
      reference_for(options, ready, out.map, replay);

  if (options.floor) ready.rule.floor = *options.floor / sensor.background;
  out.files = files_of(options, place);
  out.solver_name = ready.name;
  out.parameters = json_text(printable_json(ready.solver->parameters()));
  out.fit = ready.fit;
  out.checked = ready.solver->fit_report().frame_check.empty();
  out.solver = std::make_unique<LiveSolver>(
      sensor, std::shared_ptr<Solver>(std::move(ready.solver)), ready.rule);
  if (reference) take_reference(*out.solver, *reference, options);
  if (options.follow) out.solver->follow_reference();
  if (!options.quiet.empty()) {
    const QuietFrames quiet = read_quiet(options.quiet, sensor, out.map);
    require_reference(sensor, quiet.reference, "--quiet", options);
    out.solver->learn_quiet(quiet.changes, quiet.runs, options.false_alarms_per_hour);
  }
  if (!options.forces.empty()) {
    const ForceFrames known = read_forces(options.forces, sensor);
    require_reference(sensor, known.reference, "--forces", options);
    out.solver->learn_forces(known.changes, known.forces_N);
  }
  const double most = most_volts / std::abs(out.map.entries.front().factor);
  out.source = source_for(options, place, {static_cast<int>(out.map.columns), most}, replay);
  if (options.lossless && !out.source->can_wait()) {
    throw InputError("--lossless: this sender does not wait; use it with - or replay: only");
  }
  return out;
}

}  // namespace ertbench
