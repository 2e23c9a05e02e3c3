#include "bench/studies/collision.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ertbench {
namespace {

constexpr int collision_areas = 5;  ///< along each side
constexpr const char* collision_roles[] = {"calibration", "quiet", "presses", "arm"};

FrameRuns collision_runs(const SequenceSet& set) {
  FrameRuns runs;
  for (std::uint64_t s = 0; s < set.sequences(); ++s) runs.first.push_back(set.first_frame(s));
  runs.first.push_back(set.frames());
  runs.frame_rate = set.timing().frame_rate;
  return runs;
}

/// The region of a place in mm from the sheet's centre.
int touched_region(const Sheet& sheet, const std::vector<int>& orbits,
                   const Eigen::Vector2d& place_mm) {
  const Eigen::Vector2d from_origin = place_mm + sheet.unit_mm() * sheet.bounds().center();
  return orbits[static_cast<std::size_t>(area_of(sheet, from_origin, collision_areas))];
}

std::vector<PressTruth> press_truths(const DatasetSpec& spec, const std::vector<int>& orbits) {
  const auto& touches = std::get<TouchDistribution>(spec.scenes);
  std::vector<PressTruth> out;
  for (std::uint64_t frame = 0; frame < spec.count; ++frame) {
    RandomStream random = spec.stream(spec.scene_number(frame), Purpose::scene);
    PressTruth press;
    press.scene = spec.scene_number(frame);
    for (const Touch& touch : touches.draw(frame, random, spec.sensor)) {
      if (touch.force_N <= press.force_N) continue;  // of several touches the hardest counts
      press.force_N = touch.force_N;
      press.region = touched_region(*spec.sensor.sheet, orbits, touch.place_mm);
    }
    out.push_back(press);
  }
  return out;
}

std::vector<ArmTruth> arm_truths(const DatasetSpec& spec, double stiffness_N_mm) {
  std::vector<ArmTruth> out;
  for (std::uint64_t s = 0; s < spec.sequences()->sequences(); ++s) {
    RandomStream random = spec.stream(s, Purpose::scene);
    const TouchSequence sequence = spec.sequences()->draw(s, random, spec.sensor);
    const std::vector<PathMoment>& points = sequence.paths.front().points;
    const double rate_N_s =
        (points[1].force_N - points[0].force_N) / (points[1].time_s - points[0].time_s);
    out.push_back({points[0].time_s, sequence.duration_s, rate_N_s / stiffness_N_mm / 1000});
  }
  return out;
}

/// The largest |δσ| of each image and the region of its contact: that of the strongest contact, of
/// an image without one that of its centroid.
AlarmSignal image_signal(const Sheet& sheet, const std::vector<int>& orbits,
                         const std::vector<FrameReading>& readings) {
  AlarmSignal out;
  for (const FrameReading& reading : readings) {
    out.magnitude.push_back(reading.peak ? std::abs(*reading.peak)
                                         : std::numeric_limits<double>::quiet_NaN());
    std::optional<Eigen::Vector2d> place_mm = reading.centroid25_mm;
    if (!reading.contacts.empty()) place_mm = reading.contacts.front().place_mm;
    out.region.push_back(
        place_mm ? orbits[static_cast<std::size_t>(area_of(sheet, *place_mm, collision_areas))]
                 : -1);
  }
  return out;
}

AlarmSignal voltage_signal(const DatasetFile& file) {
  constexpr std::uint64_t block = 4096;
  AlarmSignal out;
  for (std::uint64_t first = 0; first < file.size(); first += block) {
    const Frames frames = file.voltages(first, std::min(block, file.size() - first));
    for (Eigen::Index f = 0; f < frames.rows(); ++f) {
      out.magnitude.push_back((frames.row(f).transpose() - file.reference_voltages()).norm());
    }
  }
  out.region.assign(out.magnitude.size(), 0);
  return out;
}

/// The signals of one source, by role; `signal_of` is given the name of the set.
template <typename SignalOf>
DetectorSignals signals_by_role(const StudySpec& spec, const SignalOf& signal_of) {
  DetectorSignals out;
  AlarmSignal* const signals[] = {&out.calibration, &out.quiet, &out.presses, &out.arm};
  for (std::size_t r = 0; r < std::size(collision_roles); ++r) {
    *signals[r] = signal_of(spec.roles.at(collision_roles[r]));
  }
  return out;
}

DetectorSignals without_regions(DetectorSignals signals) {
  for (AlarmSignal* signal :
       {&signals.calibration, &signals.quiet, &signals.presses, &signals.arm}) {
    std::fill(signal->region.begin(), signal->region.end(), 0);
  }
  return signals;
}

/// The first set's law and noise, and the other sets' noise where it is another.
std::string collision_condition(const StudyInput& input) {
  std::vector<std::string> noises;
  std::string listed;
  for (const char* role : collision_roles) {
    noises.push_back(noise_text(input.set_spec(input.spec.roles.at(role)).noise));
    listed += (listed.empty() ? "" : ", ") + std::string(role) + " " + noises.back();
  }
  const bool same = std::count(noises.begin(), noises.end(), noises.front()) ==
                    static_cast<std::ptrdiff_t>(noises.size());
  return input.law() + " law, " + (same ? noises.front() : listed);
}

bool has_readings(const StudyInput& input, const std::string& label) {
  return std::all_of(std::begin(collision_roles), std::end(collision_roles), [&](const char* role) {
    return input.readings(label, input.spec.roles.at(role)) != nullptr;
  });
}

CollisionTruth collision_truth(const StudyInput& input, const std::vector<int>& orbits,
                               const std::vector<int>& region_areas) {
  const auto set_of = [&](const char* role) -> const DatasetSpec& {
    return input.set_spec(input.spec.roles.at(role));
  };
  CollisionTruth truth;
  for (const int areas : region_areas) {
    truth.region_shares.push_back(areas / static_cast<double>(orbits.size()));
  }
  truth.calibration = collision_runs(*set_of("calibration").sequences());
  truth.quiet = collision_runs(*set_of("quiet").sequences());
  truth.presses = press_truths(set_of("presses"), orbits);
  truth.arm = collision_runs(*set_of("arm").sequences());
  truth.arm_timing = set_of("arm").sequences()->timing();
  truth.arm_runs = arm_truths(set_of("arm"), input.spec.number("stiffness_N_mm"));
  return truth;
}

}  // namespace

Study collision_study(const StudyInput& input) {
  CollisionResults results;
  const StudySpec& spec = input.spec;
  const Sheet& sheet = *input.experiment.sensor.sheet;
  const std::vector<int> orbits = area_orbits(sheet, collision_areas);
  results.condition = collision_condition(input);
  results.per_hour = spec.number("false_alarms_per_hour");
  results.arm = {spec.number("stiffness_N_mm"), spec.number("deceleration_m_s2"),
                 spec.number("aim_N"),          spec.number("limit_N"),
                 spec.number("clearance_mm"),   spec.number("aside_mm")};
  results.region_areas.assign(
      static_cast<std::size_t>(*std::max_element(orbits.begin(), orbits.end()) + 1), 0);
  for (const int orbit : orbits) ++results.region_areas[static_cast<std::size_t>(orbit)];
  const CollisionTruth truth = collision_truth(input, orbits, results.region_areas);
  results.frame_rate = truth.arm.frame_rate;
  results.calibration_hours = truth.calibration.hours();

  std::vector<DetectorSignals> signals;  // of each detector
  const auto assess = [&](const std::string& label, AlarmRule rule, DetectorSignals seen,
                          std::optional<double> latency_s) {
    results.detectors.push_back(
        assess_detector(label, rule, seen, truth, results.per_hour, latency_s, results.arm));
    signals.push_back(std::move(seen));
  };
  for (const std::string& label : input.labels()) {
    if (!has_readings(input, label)) {
      for (const AlarmRule rule : {AlarmRule::by_region, AlarmRule::one_threshold}) {
        Detector& failed = results.detectors.emplace_back();
        failed.label = label;
        failed.rule = rule;
        failed.failure = input.failure(label).empty() ? "no images" : input.failure(label);
        signals.emplace_back();
      }
      continue;
    }
    const auto latency = input.latency(label);
    const auto latency_s = latency ? std::optional(latency->p50_s) : std::nullopt;
    const DetectorSignals seen = signals_by_role(spec, [&](const std::string& set) {
      return image_signal(sheet, orbits, *input.readings(label, set));
    });
    assess(label, AlarmRule::by_region, seen, latency_s);
    assess(label, AlarmRule::one_threshold, without_regions(seen), latency_s);
  }
  assess("norm of the voltages", AlarmRule::voltage_norm,
         signals_by_role(spec,
                         [&](const std::string& set) { return voltage_signal(input.open(set)); }),
         0.0);

  std::vector<ArmRun> undelayed;
  for (const ArmTruth& run : truth.arm_runs) undelayed.push_back(undelayed_run(run, results.arm));
  results.undelayed = arm_outcome(std::move(undelayed), results.arm, "undelayed");
  results.reference = reference_bin(results.detectors);
  for (std::size_t d = 0; d < signals.size() && results.reference; ++d) {
    Detector& detector = results.detectors[d];
    if (!detector.failure.empty()) continue;
    detector.curve =
        operating_curve(detector, signals[d], truth, detector.by_force[*results.reference]);
  }
  return study_of_collision(spec.name, results);
}

}  // namespace ertbench
