#include "bench/studies/collision.h"

#include <algorithm>
#include <functional>

#include "core/lists.h"
#include "core/text.h"

namespace ertbench {
namespace {

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
  return orbits[static_cast<std::size_t>(area_of(sheet, from_origin))];
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
    out.push_back({points[0].time_s, rate_N_s / stiffness_N_mm / 1000});
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
DetectorSignals signals_by_role(const StudySpec& spec,
                                const std::function<AlarmSignal(const std::string&)>& signal_of) {
  const auto in = [&](const char* role) { return signal_of(spec.roles.at(role)); };
  return {in("calibration"), in("quiet"), in("presses"), in("arm")};
}

DetectorSignals without_regions(DetectorSignals signals) {
  for (AlarmSignal* signal :
       {&signals.calibration, &signals.quiet, &signals.presses, &signals.arm}) {
    std::ranges::fill(signal->region, 0);
  }
  return signals;
}

/// The law and the noise of the sets, by role where they differ.
std::string collision_condition(const StudyInput& input) {
  std::vector<std::string> noises, listed;
  for (const char* role : collision_roles) {
    noises.push_back(noise_text(input.set_spec(input.spec.roles.at(role)).noise));
    listed.push_back(role + (" " + noises.back()));
  }
  return input.law() + " law, " + (distinct(noises).size() == 1 ? noises.front() : joined(listed));
}

bool has_readings(const StudyInput& input, const std::string& label) {
  return std::ranges::all_of(collision_roles, [&](const char* role) {
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

/// The study's method, for the report.
std::string collision_text(const CollisionResults& results) {
  return "An image raises an alarm when its largest |δσ| reaches a threshold: one for the whole "
         "sheet, or that of the region (of the symmetry orbits of 5 × 5 areas, I the corners to VI "
         "the centre) in which the strongest contact lies. Thresholds are set on frames in which "
         "nothing touches, so that " +
         number_text(results.per_hour) +
         " alarms an hour are false, each region having a share in proportion to its area. So rare "
         "a value lies beyond what was seen: the excesses of peaks over a high level are taken to "
         "be exponential and extrapolated. For comparison stands an alarm by the 2-norm of the "
         "voltages' change, which needs no image.\n\nThe arm goes on at its speed until the alarm "
         "and then decelerates; the force on the obstacle grows with the way. The delay counts "
         "from the first touch to the end of the solver's work on the frame that raised the alarm; "
         "a solver that is slower than the frames takes the newest and drops the others.";
}

/// Notes on reading the tables.
std::vector<std::string> collision_notes(const CollisionResults& results) {
  return {
      "Intervals are 95 %: of thresholds by the bootstrap over blocks of frames, of counts exact "
      "Poisson intervals, of shares Wilson's, else by the bootstrap over scenes or sequences. A "
      "Poisson interval takes alarms to be independent, which under drift they are not.",
      "Alarm frames that follow each other are one alarm; \"quiet time in alarm\" shows where such "
      "an alarm does not end.",
      "\"of the whole sheet\": fewer than 30 of the calibration frames have their largest value in "
      "that region, which takes the threshold of the whole sheet.",
      "Least force: where the isotonic fit of detection against force reaches 95 %. \"> x\": not "
      "at the largest force pressed; \"≤ x\": at the twenty lightest presses already; a dash: "
      "fewer than forty presses.",
      "Runs in which an alarm came before anything touched are needless stops; they count against "
      "the tasks done and stand in no delay, no force and no speed. A run without an alarm has an "
      "endless delay, and the limit (" +
          number_text(results.arm.limit_N) + " N) or more for its force.",
      "Time lost: by the runs that stopped, in decelerating, retreating to " +
          number_text(results.arm.clearance_mm) + " mm from the obstacle and passing " +
          number_text(results.arm.aside_mm) + " mm aside, over going straight on.",
      "Of it latency: what a solver that takes no time would save of the delays, waiting for its "
      "turn included. Where the latency has a dash it was not measured and counts as 0.",
      "Highest speed: up to which 95 % of the runs stay under " + number_text(results.arm.aim_N) +
          " N. Without any delay the way v²/2a alone allows " +
          fixed(results.arm.highest_speed_m_s(), 3) +
          " m/s. \"< x\": not even the slowest runs do; a dash: fewer than forty runs."};
}

void add_headlines(const Detector& detector, std::vector<Headline>& out) {
  if (!detector.failure.empty() || detector.rule == AlarmRule::voltage_norm) return;
  const std::string rule = std::string(name_of(detector.rule)) + ": ";
  const auto& least_N = detector.least_N;
  out.push_back({detector.label, rule + "force that is found in 95 % (N)", 2,
                 least_N ? std::optional(least_N->value) : std::nullopt});
  out.push_back({detector.label, rule + "median delay of the arm (ms)", 1,
                 value_of(scaled(detector.arm.median_delay_s, 1000))});
}

CollisionResults collision_results(const StudyInput& input) {
  CollisionResults results;
  const StudySpec& spec = input.spec;
  const TouchRegions regions(input.experiment.sensor);
  const std::vector<int>& orbits = regions.region_of();
  results.condition = collision_condition(input);
  results.per_hour = spec.number("false_alarms_per_hour");
  results.arm = {spec.number("stiffness_N_mm"), spec.number("deceleration_m_s2"),
                 spec.number("aim_N"),          spec.number("limit_N"),
                 spec.number("clearance_mm"),   spec.number("aside_mm")};
  results.region_areas.assign(static_cast<std::size_t>(*std::ranges::max_element(orbits) + 1), 0);
  for (const int orbit : orbits) ++results.region_areas[static_cast<std::size_t>(orbit)];
  const CollisionTruth truth = collision_truth(input, orbits, results.region_areas);
  results.frame_rate = truth.arm.frame_rate;
  results.calibration_hours = truth.calibration.hours();

  const auto assess = [&](const std::string& label, AlarmRule rule, const DetectorSignals& seen,
                          std::optional<double> latency_s) {
    results.detectors.push_back(
        assess_detector(label, rule, seen, truth, results.per_hour, latency_s, results.arm));
  };
  for (const std::string& label : input.labels()) {
    if (!has_readings(input, label)) {
      for (const AlarmRule rule : {AlarmRule::by_region, AlarmRule::one_threshold}) {
        Detector& failed = results.detectors.emplace_back();
        failed.label = label;
        failed.rule = rule;
        failed.failure = input.failure(label).empty() ? "no images" : input.failure(label);
      }
      continue;
    }
    const auto latency_s = input.latency_s(label);
    const DetectorSignals seen = signals_by_role(
        spec, [&](const std::string& set) { return regions.signal(*input.readings(label, set)); });
    assess(label, AlarmRule::by_region, seen, latency_s);
    assess(label, AlarmRule::one_threshold, without_regions(seen), latency_s);
  }
  assess("norm of the voltages", AlarmRule::voltage_norm,
         signals_by_role(spec,
                         [&](const std::string& set) { return voltage_signal(input.open(set)); }),
         0.0);

  std::vector<ArmRun> undelayed;
  for (const ArmTruth& run : truth.arm_runs) undelayed.push_back(delayed_run(0, run, results.arm));
  results.undelayed = arm_outcome(std::move(undelayed), results.arm, "undelayed");
  return results;
}

}  // namespace

Study collision_study(const StudyInput& input) {
  const auto results = std::make_shared<CollisionResults>(collision_results(input));
  Study study(input.spec.name, "Collision (D.5)", collision_json(*results));
  for (const Detector& detector : results->detectors) add_headlines(detector, study.best);
  StudySection& section = study.sections.front();
  section.report.text = collision_text(*results);
  section.report.notes = collision_notes(*results);
  add_collision_tables(*results, section);
  section.figures = {collision_figure(results)};
  return study;
}

}  // namespace ertbench
