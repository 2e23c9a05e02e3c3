#include "bench/experiment/study_spec.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "bench/experiment/experiment.h"
#include "bench/experiment/experiment_json.h"
#include "core/errors.h"
#include "core/json.h"
#include "core/lists.h"
#include "core/text.h"
#include "forward/data/measured_file.h"

namespace ertbench {
namespace {

/// What a test set must be for a study to read it.
struct SetKind {
  const char* description;
  bool (*fits)(const DatasetSpec&);
};

template <typename Plan>
const Plan* plan_of(const DatasetSpec& set) {
  return set.sequences() ? std::get_if<Plan>(&set.sequences()->plan()) : nullptr;
}

template <typename Plan>
bool has_plan(const DatasetSpec& set) {
  return plan_of<Plan>(set) != nullptr;
}

template <int touched_fraction>
bool collides(const DatasetSpec& set) {
  const auto* plan = plan_of<CollidePlan>(set);
  return plan && plan->touched_fraction == touched_fraction;
}

const SetKind at_places = {"touches at \"places\"", [](const DatasetSpec& set) {
                             const auto* d = std::get_if<TouchDistribution>(&set.scenes);
                             return d && d->places.has_value();
                           }};
const SetKind touched = {"\"touches\" at rest", [](const DatasetSpec& set) {
                           return std::holds_alternative<TouchDistribution>(set.scenes);
                         }};
const SetKind pressed = {"sequences of the kind \"press\"", has_plan<PressPlan>};
const SetKind written = {"sequences of the kind \"write\"", has_plan<WritePlan>};
const SetKind quiet = {R"(sequences of the kind "collide" with "touched_fraction": 0)",
                       collides<0>};
const SetKind collided = {R"(sequences of the kind "collide" with "touched_fraction": 1)",
                          collides<1>};
const SetKind any_frames = {"frames", [](const DatasetSpec&) { return true; }};

struct Role {
  const char* key;
  SetKind kind;
};

struct Number {
  const char* key;
  double otherwise;
  Range range;
};

struct StudyType {
  std::string name;
  std::optional<SetKind> sets;
  std::vector<Role> roles;
  std::vector<Number> numbers;
};

const std::vector<StudyType>& study_types() {
  static const std::vector<StudyType> types = {
      {"localisation", at_places, {}, {}},
      {"consistency", any_frames, {{"empty", any_frames}}, {{"outlier", 0.05, {0, 1, false}}}},
      {"sensitivity", pressed, {{"calibration", pressed}}, {}},
      {"targets", touched, {}, {}},
      {"tracking", written, {}, {}},
      {"arm_hour",
       std::nullopt,
       {},
       {{"minutes", 60, {0.1, 1e4, false, "min"}},
        {"frame_rate", 100, {1, 1e4, false, "1/s"}},
        {"snr_db", 50, {0, 200, false, "dB"}},
        {"seed", 1, {0, 1e9, false}}}},
      {"collision",
       std::nullopt,
       {{"calibration", quiet}, {"quiet", quiet}, {"presses", touched}, {"arm", collided}},
       {{"false_alarms_per_hour", 10, {1e-3, 1e6, false}},
        {"stiffness_N_mm", 5, {1e-3, 1e6, false, "N/mm"}},
        {"deceleration_m_s2", 5, {1e-3, 1e6, false, "m/s^2"}},
        {"aim_N", 10, {1e-3, 1e6, false, "N"}},
        {"limit_N", 140, {1e-3, 1e6, false, "N"}},
        {"clearance_mm", 10, {0, 1e6, false, "mm"}},
        {"aside_mm", 50, {1e-3, 1e6, false, "mm"}}}}};
  return types;
}

const StudyType& read_type(JsonObject& object) {
  const std::string name = object.choice("type", distinct(study_types(), &StudyType::name));
  return *std::ranges::find(study_types(), name, &StudyType::name);
}

/// The test set of that name. `key` is where it stands.
std::string require_set(JsonObject& object, const Experiment& experiment, const std::string& key,
                        const std::string& name, const SetKind& kind) {
  const auto test = std::ranges::find(experiment.tests, name, &DatasetSpec::name);
  if (test == experiment.tests.end()) {
    object.fail(key, "there is no such test set; there are " +
                         joined(experiment.tests, ", ", &DatasetSpec::name));
  }
  if (!kind.fits(*test)) {
    object.fail(key,
                "must hold " + std::string(kind.description) + ", which \"" + name + "\" does not");
  }
  return name;
}

/// Presses that are read together divide the sheet alike.
void require_equal_areas(JsonObject& object, const Experiment& experiment, const StudySpec& study) {
  if (study.type != "sensitivity") return;
  const auto areas = [&](const std::string& set) {
    return plan_of<PressPlan>(*experiment.find_dataset(set))->areas;
  };
  std::vector<std::string> sets = study.sets;
  sets.push_back(study.roles.at("calibration"));
  for (const std::string& set : sets) {
    if (areas(set) == areas(sets.front())) continue;
    object.fail(
        "", "\"" + set + "\" must divide the sheet into as many areas as \"" + sets.front() + "\"");
  }
}

StudySpec read_study(JsonObject& object, const Experiment& experiment) {
  const StudyType& type = read_type(object);
  StudySpec study;
  study.type = type.name;
  study.name = object.text_or("name", type.name);
  if (!is_name(study.name)) {
    object.fail("name", "must be made of letters, digits, \"_\" and \"-\" (at most 60)");
  }
  if (type.sets) {
    const std::vector<std::string> tests = distinct(experiment.tests, &DatasetSpec::name);
    for (const std::string& name : object.choices("sets", tests)) {
      study.sets.push_back(require_set(object, experiment, "sets", name, *type.sets));
    }
  }
  if (study.type == "localisation") {
    study.maps = object.has("maps") ? object.choices("maps", study.sets)
                                    : std::vector<std::string>{study.sets.front()};
  }
  for (const Role& role : type.roles) {
    study.roles[role.key] =
        require_set(object, experiment, role.key, object.text(role.key), role.kind);
  }
  require_equal_areas(object, experiment, study);
  for (const std::string& set : study.sets) {
    if (set == experiment.contacts.chosen_on) {
      object.fail("sets", "must leave out \"" + set +
                              "\", on which /contacts/chosen_on has the rule of contacts chosen");
    }
  }
  for (const Number& number : type.numbers) {
    study.numbers[number.key] = object.number_or(number.key, number.otherwise, number.range);
  }
  object.finish();
  return study;
}

/// Networks need two frames to learn from and one to be chosen by.
constexpr int fewest_presses = 5;

/// The files of presses that "skins" lists, each on a sheet of its own (sensor_of_presses).
std::vector<DatasetSpec> read_skins(JsonObject& object, const DatasetSpec& train,
                                    const std::filesystem::path& folder) {
  const nlohmann::json& names = object.raw("skins");
  const auto fail = [&](const std::string& message) { object.fail("skins", message); };
  if (!names.is_array() || names.empty()) fail("must list one or more files of presses");
  std::vector<DatasetSpec> skins;
  std::set<std::string> taken;
  for (const nlohmann::json& name : names) {
    if (!name.is_string()) fail("must name files, got " + json_shown(name));
    const std::filesystem::path file = std::filesystem::absolute(folder / name.get<std::string>());
    if (!std::filesystem::is_regular_file(file)) {
      fail("there is no file " + printable_path(file.string()) +
           "; a relative path begins at the experiment's folder");
    }
    try {
      const nlohmann::json set = {{"file", file.string()}};
      DatasetSpec& skin = skins.emplace_back(dataset_spec_from_json(
          JsonObject(set, "skins", ""), sensor_of_presses(file), "train", folder));
      skin.noise = train.noise;
    } catch (const InputError& wrong) {
      fail(wrong.what());
    }
    if (!taken.insert(skins.back().measured()->name).second) {
      fail("two files have the name " + printable_path(file.filename().string()) +
           "; give each skin's file its own");
    }
  }
  return skins;
}

/// The rows of the training set's file that are divided.
MeasuredFrames divided_frames(JsonObject& object, const Experiment& experiment,
                              MeasuredFrames frames) {
  frames.fold.reset();
  if (object.has("rows")) {
    const std::vector<double> ends = object.numbers("rows", 2, {0, 1e9});
    frames.first = static_cast<std::uint64_t>(ends[0]);
    frames.last = static_cast<std::uint64_t>(ends[1]);
    const DatasetSpec* last = nullptr;
    for (const DatasetSpec* spec : experiment.datasets()) {
      const MeasuredFrames* other = spec->measured();
      if (other && other->checksum == frames.checksum &&
          (!last || other->last > last->measured()->last)) {
        last = spec;
      }
    }
    if (frames.first >= frames.last || frames.last > last->measured()->last) {
      object.fail("rows",
                  "must be [first, last) of rows that the experiment's datasets of that "
                  "file reach, up to " +
                      std::to_string(last->measured()->last));
    }
  }
  return frames;
}

}  // namespace

std::vector<StudySpec> read_studies(JsonObject& root, const Experiment& experiment) {
  std::vector<StudySpec> studies;
  if (!root.has("studies")) return studies;
  std::set<std::string> taken;
  for (JsonObject& object : root.objects("studies")) {
    studies.push_back(read_study(object, experiment));
    if (!taken.insert(studies.back().name).second) {
      object.fail("name", "\"" + studies.back().name + "\" is taken; give every study its own");
    }
  }
  return studies;
}

std::uint64_t Folds::validation_count(std::uint64_t number) const {
  const auto share = static_cast<std::uint64_t>(std::lround(validation * double(number)));
  return std::clamp<std::uint64_t>(share, 1, number - 2);
}

std::uint64_t Folds::most(const DatasetSpec& skin) const {
  const std::uint64_t rows = skin.measured()->last - skin.measured()->first;
  const auto shares = static_cast<std::uint64_t>(count);
  return rows - (rows + shares - 1) / shares;
}

DatasetSpec Folds::part(const char* name, const DatasetSpec& skin, const FoldPart& fold) const {
  DatasetSpec out = skin;
  MeasuredFrames frames = *skin.measured();
  frames.fold = fold;
  out.name = name;
  out.count = frames.rows().size();
  out.scenes = std::move(frames);
  return out;
}

DatasetSpec Folds::training(int fold, std::uint64_t number) const {
  return part("train", skin_of(fold),
              {count, fold % count, false, 0, number - validation_count(number), seed});
}

DatasetSpec Folds::validation_set(int fold, std::uint64_t number) const {
  DatasetSpec out =
      part("validation", skin_of(fold),
           {count, fold % count, false, number - validation_count(number), number, seed});
  out.noise = {};  // what is added to train with is not what is measured
  return out;
}

DatasetSpec Folds::test(int fold) const {
  DatasetSpec out = part("held-out", skin_of(fold), {count, fold % count, true, 0, 0, seed});
  out.noise = {};
  return out;
}

std::optional<Folds> read_folds(JsonObject& root, const Experiment& experiment) {
  if (!root.has("folds")) return std::nullopt;
  JsonObject object = root.object("folds");
  const DatasetSpec* train = experiment.training ? &*experiment.training : nullptr;
  if (train == nullptr || train->measured() == nullptr || !train->measured()->truth.places) {
    root.fail("folds",
              "divide measured frames with known places; let /datasets/train name such a \"file\"");
  }
  Folds folds;
  if (object.has("skins")) {
    if (object.has("rows")) object.fail("rows", "goes with no \"skins\"; remove one of the two");
    folds.skins = read_skins(object, *train, experiment.file.parent_path());
  } else {
    folds.skins = {*train};
    folds.skins[0].scenes = divided_frames(object, experiment, *train->measured());
  }
  std::uint64_t rows = 0;
  for (const DatasetSpec& skin : folds.skins) {
    rows = std::max(rows, skin.measured()->last - skin.measured()->first);
  }
  folds.count = object.integer_or("count", folds.count, 2, 100);
  if (static_cast<std::uint64_t>(folds.count) > rows) {
    object.fail("count", "must be at most the number of rows, " + std::to_string(rows));
  }
  std::uint64_t most = 0;
  for (const DatasetSpec& skin : folds.skins) most = std::max(most, folds.most(skin));
  if (object.has("presses")) {
    const auto limit = static_cast<int>(std::min<std::uint64_t>(most, 1000000));
    for (const int number : object.integers("presses", 1, 20, {fewest_presses, limit})) {
      folds.presses.push_back(static_cast<std::uint64_t>(number));
    }
    std::ranges::sort(folds.presses);
    folds.presses.erase(std::unique(folds.presses.begin(), folds.presses.end()),
                        folds.presses.end());
  } else if (most < fewest_presses) {
    object.fail("count", "leaves fewer than 5 presses to learn from");
  } else {
    folds.presses = {most};
  }
  folds.validation = object.number_or("validation", folds.validation, {0, 0.9});
  folds.seed = static_cast<std::uint64_t>(object.integer_or("seed", 1, 0, 2147483647));
  object.finish();
  return folds;
}

nlohmann::json to_json(const Folds& folds) {
  nlohmann::json out = {{"base", to_json(folds.skins[0])},
                        {"count", folds.count},
                        {"presses", folds.presses},
                        {"validation", folds.validation},
                        {"seed", folds.seed}};
  for (std::size_t s = 1; s < folds.skins.size(); ++s) {
    out["skins"].push_back(to_json(folds.skins[s]));
  }
  return out;
}

}  // namespace ertbench
