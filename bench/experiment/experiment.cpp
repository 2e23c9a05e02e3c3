#include "bench/experiment/experiment.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/experiment_json.h"
#include "bench/experiment/experiment_solvers.h"
#include "core/errors.h"
#include "core/fields.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "frames/calibration.h"
#include "solvers/registry/registry.h"

namespace ertbench {
namespace {

constexpr int least_timed_frames = 662;  // fewer leave the 99th percentile without an interval

/// Refuses frames of a file in two sets of which one is learned from: their error says nothing.
void refuse_learned_frames(const JsonObject& object, const Experiment& experiment) {
  const std::vector<const DatasetSpec*> sets = experiment.datasets();
  for (auto set = sets.begin(); set != sets.end(); ++set) {
    for (auto learned = sets.begin(); learned != set; ++learned) {
      const MeasuredFrames* own = (*set)->measured();
      const MeasuredFrames* other = (*learned)->measured();
      const bool is_test = (*learned)->name != "train" && (*learned)->name != "validation";
      if (is_test || !own || !other || own->checksum != other->checksum) continue;
      std::set<std::uint64_t> rows;
      const std::vector<std::uint64_t> of_both[] = {own->rows(), other->rows()};
      for (const auto& some : of_both) rows.insert(some.begin(), some.end());
      const std::size_t shared = of_both[0].size() + of_both[1].size() - rows.size();
      if (shared == 0) continue;
      object.fail((*set)->name, "has " + std::to_string(shared) + " frames of " + own->name +
                                    " that \"" + (*learned)->name +
                                    "\", from which solvers learn, has too; give other \"rows\"");
    }
  }
}

void read_datasets(JsonObject object, Experiment& experiment) {
  for (const std::string& name : object.keys()) {
    if (!is_name(name)) {
      object.fail(name, "a dataset's name must be made of letters, digits, \"_\" and \"-\"");
    }
    DatasetSpec spec = dataset_spec_from_json(object.object(name), experiment.sensor, name,
                                              experiment.file.parent_path());
    if (name == "train") {
      experiment.training = std::move(spec);
    } else if (name == "validation") {
      experiment.validation = std::move(spec);
    } else {
      experiment.tests.push_back(std::move(spec));
    }
  }
  if (experiment.tests.empty()) {
    object.fail("",
                "needs a test set: a dataset by another name than \"train\" and \"validation\"");
  }
  refuse_learned_frames(object, experiment);
}

/// Reads "calibration", the name of a file relative to the experiment's, which sets the sensor's
/// background, or the whole sensor if the experiment has none. Returns nothing without the key.
/// Throws InputError if the file is of another sensor.
std::optional<Calibration> read_calibration_of(JsonObject& root, Experiment& experiment) {
  if (!root.has("calibration")) return std::nullopt;
  std::filesystem::path file = experiment.file.parent_path() / root.text("calibration");
  Calibration calibration = read_calibration(file);
  if (root.has("sensor")) {
    require_calibration_of(calibration, experiment.sensor, file);
  } else {
    experiment.sensor = calibration.sensor;
  }
  experiment.sensor.background = calibration.background;
  experiment.files.push_back(std::move(file));
  return calibration;
}

/// Names the user's own solver libraries to the registry; in the file they are relative to it.
void read_plugins(JsonObject& root, Experiment& experiment, SolverRegistry& registry,
                  SolverCheck check) {
  if (!root.has("plugins")) return;
  const nlohmann::json& names = root.raw("plugins");
  if (!names.is_array()) root.fail("plugins", "must be a list of shared libraries");
  for (const nlohmann::json& name : names) {
    if (!name.is_string())
      root.fail("plugins", "must name shared libraries, got " + json_shown(name));
    std::filesystem::path library = experiment.file.parent_path() / name.get<std::string>();
    registry.add_library(library);
    experiment.plugins.push_back(std::move(library));
  }
  if (check == SolverCheck::none) return;
  try {
    registry.describe_libraries();
  } catch (const InputError& e) {
    root.fail("plugins", e.what());
  }
}

void visit(Fields& fields, TimingSettings& timing) {
  fields.boolean("enabled", timing.enabled);
  fields.integer("frames", timing.frames, least_timed_frames, 1000000);
  fields.integer("warm_up", timing.warm_up, 1, 100000);
  fields.integer("batch", timing.batch, 1, 65536);
  fields.integer("rounds", timing.rounds, 1, 100);
}

void visit(Fields& fields, ContactSettings& contacts, const std::vector<DatasetSpec>& tests) {
  fields.number_or_auto("threshold", contacts.threshold, {0, 1});
  fields.number_or_auto("floor", contacts.floor, {0, 1e6});
  fields.name("chosen_on", contacts.chosen_on, distinct(tests, &DatasetSpec::name));
  fields.number("saddle", contacts.saddle, {0, 1});
  fields.number_or_auto("match_mm", contacts.match_mm, {0, 1e6, true, "mm"});
  fields.number_or_auto("ospa_mm", contacts.ospa_mm, {0, 1e6, true, "mm"});
}

void visit(Fields& fields, CheckSettings& check) {
  fields.derived().integer("seeds", check.seeds, 1, 100);
  fields.derived().integer("baseline_seeds", check.baseline_seeds, 3, 100);
}

/// The settings that follow from no other part of the experiment.
void visit(Fields& fields, Experiment& experiment) {
  fields.number("time_limit_s", experiment.time_limit_s, {0, 1e7, true});
  fields.number("memory_limit_mb", experiment.memory_limit_mb, {64, 1e9});
  fields.object("timing", [&](Fields& timing) { visit(timing, experiment.timing); });
  fields.object("contacts",
                [&](Fields& contacts) { visit(contacts, experiment.contacts, experiment.tests); });
  fields.object("check", [&](Fields& check) { visit(check, experiment.check); });
}

void read_right_sizing(JsonObject& root, Experiment& experiment) {
  if (!root.has("right_sizing")) return;
  JsonObject object = root.object("right_sizing");
  RightSizing& sizing = experiment.right_sizing.emplace();
  sizing.margin = object.number_or("margin", sizing.margin, {0, 10});
  sizing.metric = metric_from_name(
      object.choice_or("metric", name_of(sizing.metric), accepted_names(kErrorMetrics)));
  object.finish();
  if (!experiment.validation) {
    root.fail("right_sizing", "chooses on the validation set; add /datasets/validation");
  }
}

constexpr int most_figure_scenes = 12;

void read_figure(JsonObject& root, Experiment& experiment) {
  const int count =
      static_cast<int>(std::min<std::uint64_t>(experiment.tests[0].count, 1000000000));
  if (!root.has("figure")) {
    for (int s = 0; s < std::min(5, count); ++s) experiment.figure_scenes.push_back(s);
    return;
  }
  JsonObject object = root.object("figure");
  const nlohmann::json& scenes = object.raw("scenes");
  if (scenes.is_number_integer() && scenes > 0 && scenes <= most_figure_scenes) {
    // So many, evenly through the set from its first to its last.
    const int wanted = std::min(scenes.get<int>(), count);
    for (int s = 0; s < wanted; ++s) {
      const std::int64_t at = wanted == 1 ? 0 : std::int64_t{s} * (count - 1) / (wanted - 1);
      experiment.figure_scenes.push_back(static_cast<int>(at));
    }
    return object.finish();
  }
  if (!scenes.is_array() || scenes.size() > most_figure_scenes) {
    object.fail("scenes", "must be a list of at most " + std::to_string(most_figure_scenes) +
                              " scene numbers, or how many, from 1 to as many");
  }
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    if (!scenes[s].is_number_integer() || scenes[s] < 0 || scenes[s] >= count) {
      object.fail("scenes", "must be scene numbers from 0 to " + std::to_string(count - 1) +
                                " of \"" + experiment.tests[0].name + "\", got " +
                                json_shown(scenes[s]));
    }
    experiment.figure_scenes.push_back(scenes[s].get<int>());
  }
  object.finish();
}

void read_published(JsonObject& root, Experiment& experiment) {
  if (!root.has("published")) return;
  JsonObject object = root.object("published");
  experiment.published.source = object.text("source");
  if (object.has("datasets")) {
    const nlohmann::json& names = object.raw("datasets");
    if (!names.is_array()) object.fail("datasets", "must be a list of test sets");
    for (const auto& name : names) {
      const bool test = name.is_string() &&
                        std::ranges::any_of(experiment.tests,
                                            [&](const DatasetSpec& d) { return d.name == name; });
      if (!test)
        object.fail("datasets", "must name test sets of this experiment, got " + json_shown(name));
      experiment.published.datasets.push_back(name);
    }
  }
  // Our lengths are half sides; a published side of length 1 is two of them.
  const bool sides = object.choice_or("length_unit", "half side", {"half side", "side"}) == "side";
  JsonObject rows = object.object("rows");
  for (const std::string& label : rows.keys()) {
    PublishedRow row{label, {}};
    JsonObject values = rows.object(label);
    for (const Metric metric : kMetrics) {
      const char* key = key_in_file(metric, [&](const char* k) { return values.has(k); });
      if (key == nullptr) continue;
      const bool length = entry_of(metric).quantity == Quantity::length;
      row.values[metric] = values.number(key, {-1e6, 1e6}) * (length && sides ? 2 : 1);
    }
    values.finish();
    experiment.published.rows.push_back(row);
  }
  rows.finish();
  object.finish();
}

}  // namespace

const DatasetSpec* Experiment::find_dataset(const std::string& dataset) const {
  for (const DatasetSpec* spec : datasets()) {
    if (spec->name == dataset) return spec;
  }
  return nullptr;
}

std::vector<const DatasetSpec*> Experiment::datasets() const {
  std::vector<const DatasetSpec*> out;
  if (training) out.push_back(&*training);
  if (validation) out.push_back(&*validation);
  for (const DatasetSpec& test : tests) out.push_back(&test);
  return out;
}

std::vector<std::span<const SolverEntry>> Experiment::rows() const {
  std::vector<std::span<const SolverEntry>> out;
  for (auto first = solvers.begin(); first != solvers.end();) {
    const auto last = std::find_if(first, solvers.end(),
                                   [&](const SolverEntry& e) { return e.label != first->label; });
    out.emplace_back(first, last);
    first = last;
  }
  return out;
}

Experiment read_experiment(const std::filesystem::path& file, SolverRegistry& registry,
                           const ChartTypes& charts, SolverCheck check,
                           const std::vector<std::string>& overrides) {
  const ExperimentJson json = read_experiment_json(file, overrides);
  JsonObject root(*json.content, json.source, "");
  Experiment experiment;
  experiment.file = file;
  experiment.source = json.source;
  experiment.files = json.files;
  experiment.overrides = overrides;
  experiment.name = printable(file.stem().string());
  root.has("$schema");  // for editors
  if (root.has("data")) root.fail("data", "is of KTC2023; `ertbench run` alone takes such a file");
  experiment.title = root.text_or("title", experiment.name);
  experiment.question = root.text_or("question", experiment.title);
  experiment.made_by = root.choice_or("made_by", "run", {"run", "fidelity"});
  if (root.has("sensor")) experiment.sensor = sensor_from_json(root.object("sensor"));
  const auto calibration = read_calibration_of(root, experiment);
  read_datasets(root.object("datasets"), experiment);
  if (calibration && !experiment.validation) {  // noise of the measured level
    experiment.validation = calibrated_spec(*calibration, experiment.sensor, "validation");
  }
  Fields::read_some(root, [&](Fields& fields) { visit(fields, experiment); });
  read_plugins(root, experiment, registry, check);
  experiment.solvers = read_solvers(root, experiment, registry, check);
  experiment.folds = read_folds(root, experiment);
  experiment.studies = read_studies(root, experiment);
  experiment.keep_contacts = !experiment.studies.empty();
  experiment.keep_explained = std::ranges::any_of(
      experiment.studies, [](const StudySpec& study) { return study.type == "consistency"; });
  read_figure(root, experiment);
  read_presentation(root, experiment, charts, registry);
  experiment.ladders = read_ladders(root, experiment, registry, check);
  root.finish();
  return experiment;
}

void read_presentation(JsonObject& root, Experiment& experiment, const ChartTypes& charts,
                       SolverRegistry& registry) {
  read_right_sizing(root, experiment);
  read_published(root, experiment);
  if (root.has("charts") && !charts.empty()) {
    experiment.charts = read_charts(root, experiment, charts, registry);
  }
  nlohmann::json kept = nlohmann::json::object();
  for (const char* key : {"charts", "published", "right_sizing"}) {
    if (root.has(key)) kept[key] = root.raw(key);
  }
  experiment.presentation = kept;
}

nlohmann::ordered_json experiment_settings_schema() {
  Experiment experiment;
  return Fields::schema([&](Fields& fields) { visit(fields, experiment); });
}

FitRecipe fit_recipe(const Experiment& experiment, const SolverEntry& entry) {
  return {entry,
          experiment.sensor,
          experiment.training,
          experiment.validation,
          experiment.plugins,
          experiment.source};
}

}  // namespace ertbench
