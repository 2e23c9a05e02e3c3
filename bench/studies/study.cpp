#include "bench/studies/study.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "bench/studies/collision.h"
#include "bench/studies/consistency.h"
#include "bench/studies/localisation.h"
#include "bench/studies/sensitivity.h"
#include "bench/studies/study_trainings.h"
#include "bench/studies/targets.h"
#include "bench/studies/tracking.h"

namespace ertbench {
namespace {

/// Trainings of a solver that were scored on all sets.
std::size_t trainings_of(const ExperimentResults& results, const std::string& label) {
  const auto found = results.readings.find(label);
  if (found == results.readings.end() || found->second.empty()) return 0;
  std::size_t least = std::numeric_limits<std::size_t>::max();
  for (const auto& [set, readings] : found->second) least = std::min(least, readings.size());
  return least;
}

std::shared_ptr<const StudyResult> study_of_training(const StudyInput& input) {
  const std::string& type = input.spec.type;
  if (type == "localisation") return std::make_shared<const Localisation>(input);
  if (type == "sensitivity") return std::make_shared<const Sensitivity>(input);
  if (type == "targets") return std::make_shared<const Targets>(input);
  if (type == "tracking") return std::make_shared<const Tracking>(input);
  if (type == "collision") return std::make_shared<const Collision>(input);
  if (type == "consistency") return std::make_shared<const Consistency>(input);
  throw std::logic_error("no study is called " + type);
}

}  // namespace

std::vector<std::string> StudyInput::labels() const {
  std::vector<std::string> out;
  for (const auto entries : experiment.rows()) {
    const std::string& label = entries.front().label;
    if (training == 0 || trainings_of(results, label) > training) out.push_back(label);
  }
  return out;
}

std::size_t StudyInput::trainings() const {
  std::size_t most = 1;
  for (const auto& [label, sets] : results.readings) {
    most = std::max(most, trainings_of(results, label));
  }
  return most;
}

const DatasetSpec& StudyInput::set_spec(const std::string& set) const {
  return *experiment.find_dataset(set);
}

DatasetFile StudyInput::open(const std::string& set) const {
  return cache.open_dataset(set_spec(set));
}

const std::vector<FrameReading>* StudyInput::readings(const std::string& label,
                                                      const std::string& set) const {
  const auto found = results.readings.find(label);
  if (found == results.readings.end()) return nullptr;
  const auto frames = found->second.find(set);
  if (frames == found->second.end() || frames->second.size() <= training) return nullptr;
  return &frames->second[training];
}

std::string StudyInput::failure(const std::string& label) const {
  const auto found = results.labels.find(label);
  return found == results.labels.end() ? "not run" : found->second.failure;
}

std::optional<StudyInput::Latency> StudyInput::latency(const std::string& label) const {
  for (const ResultRow& row : results.rows) {
    if (row.label != label || !row.latency_us) continue;
    return Latency{row.latency_us->p50 * 1e-6, row.latency_us->p99 * 1e-6};
  }
  return std::nullopt;
}

std::string StudyInput::law() const { return name_of(experiment.sensor.skin->law); }

std::shared_ptr<const StudyResult> make_study(const StudyInput& input) {
  std::shared_ptr<const StudyResult> first = study_of_training(input);
  std::vector<std::vector<Headline>> of_trainings = {first->headlines()};
  for (std::size_t training = 1; training < input.trainings(); ++training) {
    StudyInput again = input;
    again.training = training;
    of_trainings.push_back(study_of_training(again)->headlines());
  }
  if (of_trainings.size() == 1) return first;
  return std::make_shared<const StudyTrainings>(input.spec.name, std::move(first),
                                                spread_of(of_trainings));
}

}  // namespace ertbench
