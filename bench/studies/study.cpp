#include "bench/studies/study.h"

#include <stdexcept>

#include "bench/studies/collision.h"
#include "bench/studies/consistency.h"
#include "bench/studies/localisation.h"
#include "bench/studies/sensitivity.h"
#include "bench/studies/targets.h"
#include "bench/studies/tracking.h"

namespace ertbench {

std::vector<std::string> StudyInput::labels() const {
  std::vector<std::string> out;
  for (const auto entries : experiment.rows()) out.push_back(entries.front().label);
  return out;
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
  return frames == found->second.end() ? nullptr : &frames->second;
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
  const std::string& type = input.spec.type;
  if (type == "localisation") return std::make_shared<const Localisation>(input);
  if (type == "sensitivity") return std::make_shared<const Sensitivity>(input);
  if (type == "targets") return std::make_shared<const Targets>(input);
  if (type == "tracking") return std::make_shared<const Tracking>(input);
  if (type == "collision") return std::make_shared<const Collision>(input);
  if (type == "consistency") return std::make_shared<const Consistency>(input);
  throw std::logic_error("no study is called " + type);
}

}  // namespace ertbench
