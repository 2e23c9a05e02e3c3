#include "bench/ktc2023/ktc_experiment.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "bench/features/parts.h"
#include "bench/ktc2023/simulated_tanks.h"
#include "core/errors.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

struct Method {
  std::string label;
  std::string calibration;
  bool normalised;
  std::unique_ptr<KtcMethod> method;
};

/// The file of an experiment on KTC2023.
struct KtcSpec {
  KtcSpec(const ExperimentJson& json, const TankModel& tank) {
    JsonObject root(*json.content, json.source, "");
    root.has("$schema");
    results.title = root.text("title");
    results.question = root.text_or("question", results.title);
    const fs::path named = root.text("data");
    data = named.is_absolute() || fs::is_directory(named) ? named : root.folder() / named;
    if (!fs::is_directory(data)) {
      root.fail("data", printable_path(named.string()) +
                            " is no folder; docs/ktc2023.md says where the competition's files "
                            "are; then --set /data=FOLDER");
    }
    levels = root.has("levels") ? root.integers("levels", 1, ktc_levels, {1, ktc_levels})
                                : std::vector{1, 2, 3, 4, 5, 6, 7};
    for (JsonObject& entry : root.objects("methods")) {
      const std::string label = entry.text_or("label", entry.text("type"));
      const std::string calibration = entry.choice_or("calibration", "all", ktc_calibration_steps);
      const bool normalised =
          entry.choice_or("difference", "plain", {"plain", "normalised"}) == "normalised";
      methods.push_back({label, calibration, normalised, ktc_method_from_json(entry, tank)});
      entry.finish();
    }
    if (root.has("simulated")) {
      JsonObject simulation = root.object("simulated");
      simulated = simulation.integer("count", 1, 1000);
      seed = simulation.integer("seed", 0, 1 << 30);
      simulation.finish();
    }
    if (root.has("official")) read_official(root.object("official"));
    root.finish();
  }

  void read_official(JsonObject official) {
    for (const std::string& label : official.keys()) {
      const std::size_t size = official.raw(label).size();
      if (size != 1 && size != ktc_levels) official.fail(label, "needs a sum or seven levels");
      results.official.emplace_back(label, official.numbers(label, size, {0, 3.0 * ktc_levels}));
    }
  }

  fs::path data;
  std::vector<int> levels;
  int simulated = 0;
  int seed = 0;
  std::vector<Method> methods;
  KtcResults results;  ///< what the file says of them
};

/// `normalised`: relative to the reference, times the model's.
KtcFrame frame_of(const KtcTarget& target, const KtcReference& reference, int level,
                  const KtcSetting& setting, bool normalised) {
  if (target.patterns.channels() != reference.patterns.channels()) {
    throw InputError(printable_path(target.reference.string()) +
                     ": has other patterns than the targets beside it");
  }
  KtcFrame out;
  out.change = target.voltages;
  out.present.setOnes(out.change.size());
  const Eigen::VectorXd model =
      setting.channels * TankModel::packed(setting.calibration.empty.resistance);
  for (Eigen::Index c = 0; c < out.change.size(); ++c) {
    out.change[c] = target.voltages[c] / target.patterns.amplitude(c) -
                    reference.voltages[c] / reference.patterns.amplitude(c);
    if (normalised) {
      out.change[c] *= model[c] / reference.voltages[c] * reference.patterns.amplitude(c);
    }
    const bool gone = target.patterns.uses_first(c, 2 * (level - 1));
    if (!gone && std::isfinite(out.change[c])) continue;
    out.change[c] = out.present[c] = 0;
  }
  return out;
}

/// A target as it was prepared for all methods.
struct Case {
  const KtcTarget* target;
  int level;
  const KtcSetting* setting;
  KtcFrame frame;
};

KtcOutcome outcome_of(const Case& one, ClassMap classes, double time_s) {
  KtcOutcome out{one.target->name, one.level, one.target->truth, std::move(classes), {}, time_s};
  if (out.truth) out.score = ktc_score(*out.truth, out.classes);
  return out;
}

void run_method(const Method& method, const std::vector<Case>& cases, std::vector<KtcRow>& rows) {
  KtcRow own{method.label, {}};
  KtcRow otsu{method.label, {}};
  for (const Case& one : cases) {
    method.method->prepare(*one.setting, one.frame);
    const auto start = std::chrono::steady_clock::now();
    const KtcImage image = method.method->reconstruct(*one.setting, one.frame);
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    otsu.outcomes.push_back(outcome_of(one, otsu_classes(image.change), time.count()));
    if (image.classes) own.outcomes.push_back(outcome_of(one, *image.classes, time.count()));
  }
  if (!own.outcomes.empty()) {
    rows.push_back(std::move(own));
    otsu.label += ", Otsu";
  }
  rows.push_back(std::move(otsu));
}

}  // namespace

std::optional<double> KtcRow::score_of(int level) const {
  double sum = 0;
  int count = 0;
  for (const KtcOutcome& outcome : outcomes) {
    if (outcome.level != level || !outcome.score) continue;
    sum += *outcome.score;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return 3 * sum / count;
}

std::optional<double> KtcRow::sum() const {
  double sum = 0;
  for (int level = 1; level <= ktc_levels; ++level) {
    const auto score = score_of(level);
    if (!score) return std::nullopt;
    sum += *score;
  }
  return sum;
}

double KtcRow::mean_score() const {
  std::vector<double> scores;
  for (const KtcOutcome& outcome : outcomes) {
    if (outcome.score) scores.push_back(*outcome.score);
  }
  return scores.empty() ? 0 : mean(scores);
}

double KtcRow::median_time_s() const {
  std::vector<double> times;
  for (const KtcOutcome& outcome : outcomes) times.push_back(outcome.time_s);
  return median(times);
}

KtcResults ktc_results(const ExperimentJson& json) {
  const TankModel tank;
  KtcSpec spec(json, tank);
  KtcResults results = std::move(spec.results);
  const std::vector<KtcTarget> targets = read_ktc_targets(spec.data);
  const bool any = std::ranges::any_of(targets, [&](const KtcTarget& target) {
    return target.any_level || std::ranges::find(spec.levels, target.level) != spec.levels.end();
  });
  if (!any) {
    throw InputError(json.source + ": /levels: no target in " + printable_path(spec.data.string()) +
                     " is of these levels");
  }
  std::map<fs::path, KtcReference> references;
  for (const KtcTarget& target : targets) {
    results.simulated_levels |= target.any_level;
    if (references.contains(target.reference)) continue;
    const KtcReference& reference =
        references.emplace(target.reference, read_ktc_reference(target.reference)).first->second;
    results.calibrations[fs::relative(target.reference, spec.data).string()] =
        calibrate_ktc(tank, reference.patterns, reference.voltages);
  }
  std::map<std::pair<fs::path, std::string>, KtcSetting> settings;
  const auto setting_of = [&](const fs::path& file, const std::string& step) -> const KtcSetting& {
    KtcSetting& setting = settings[{file, step}];
    if (setting.tank) return setting;
    const KtcReference& of = references.at(file);
    setting.calibration = calibrate_ktc(tank, of.patterns, of.voltages, step);
    setting.channels =
        channel_operator(of.patterns, setting.calibration.gain, setting.calibration.common_mode)
            .sparseView();
    setting.patterns = &of.patterns;
    setting.tank = &tank;
    return setting;
  };
  const auto run = [&](const std::vector<KtcTarget>& all) {
    const auto cases_of = [&](const std::string& step, bool normalised) {
      std::vector<Case> cases;
      for (const KtcTarget& target : all) {
        const KtcSetting& setting = setting_of(target.reference, step);
        for (const int level : spec.levels) {
          if (!target.any_level && level != target.level) continue;
          cases.push_back(
              {&target, level, &setting,
               frame_of(target, references.at(target.reference), level, setting, normalised)});
        }
      }
      return cases;
    };
    std::vector<KtcRow> rows;
    for (const Method& method : spec.methods) {
      run_method(method, cases_of(method.calibration, method.normalised), rows);
    }
    // What an image without a contact scores.
    KtcRow& empty = rows.emplace_back(KtcRow{"no-contact", {}});
    for (const Case& one : cases_of("all", false)) {
      empty.outcomes.push_back(outcome_of(one, ClassMap::Zero(256, 256), 0));
    }
    return rows;
  };
  results.rows = run(targets);
  if (spec.simulated > 0) {
    const fs::path& file = targets.front().reference;
    results.simulated =
        run(simulate_ktc_targets(references.at(file), file, setting_of(file, "all").calibration,
                                 spec.simulated, static_cast<std::uint64_t>(spec.seed)));
  }
  return results;
}

std::size_t run_ktc(const ExperimentJson& json, const fs::path& folder,
                    const std::string& command) {
  KtcResults results = ktc_results(json);
  results.command = command;
  return report_ktc(results, folder);
}

}  // namespace ertbench

extern "C" void ertbench_part_ktc2023(ertbench::Part& part) {
  part.run_ktc2023 = ertbench::run_ktc;
}
