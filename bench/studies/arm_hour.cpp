#include "bench/studies/arm_hour.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/random.h"
#include "forward/border/border_model.h"
#include "solvers/channel_mask.h"
#include "solvers/nuisances.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

constexpr std::uint64_t hour_key = key_of("arm hour");
constexpr double minute_s = 60;
constexpr double drift_per_minute = 0.001;
constexpr double step_rise_s = 10;
constexpr double largest_step = 0.02;
constexpr double creep_s = 20 * minute_s;  ///< time constant
constexpr double largest_gradient = 0.05;  ///< relative, per domain unit
constexpr double hum_share = 0.001;        ///< of the voltages' root mean square
constexpr double mains_hz = 50.02;         ///< as it is never exactly 50
constexpr double ramp_s = 0.1;             ///< in which a contact comes and goes
constexpr double tail_s = 0.25;            ///< after a contact, in which it may still be seen
constexpr double near_s = 0.5;             ///< of an event
constexpr double alarm_pause_s = 1;
constexpr double long_alarm_s = 1;

Contact arm_disc(const Vector2d& centre, double radius, double ratio) {
  Contact out;
  out.centre = centre;
  out.half_size = {radius, radius};
  out.conductivity_ratio = ratio;
  return out;
}

/// 0 before `begin_s`, 1 after a ramp, and back before `end_s`.
double there_at(double time_s, double begin_s, double end_s) {
  return std::clamp(std::min(time_s - begin_s, end_s - time_s) / ramp_s, 0.0, 1.0);
}

}  // namespace

ArmHour::ArmHour(const Sensor& sensor, const HourSettings& settings)
    : settings_(settings), seconds_(minute_s * settings.minutes) {
  const BorderModel model(sensor);
  reference_ = model.reference_voltages().transpose();
  rms_ = reference_.norm() / std::sqrt(static_cast<double>(reference_.size()));
  const double tolerance = 1e-5 * reference_.norm();
  RandomStream random(settings.seed, hour_key, 0, Purpose::fault);
  const Vector2d middle = sensor.sheet->bounds().center();
  const Contact foam =
      arm_disc(middle + Vector2d(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2)),
               0.5 * sensor.sheet->inner_radius(), 0.97);
  creep_ = model.solve({{foam}}, tolerance).change.transpose();

  const Eigen::MatrixXd gradients = Nuisances{.gradient = largest_gradient}.responses(sensor);
  for (double at_s = random.uniform(5, 30); at_s < seconds_; at_s += random.uniform(10, 50)) {
    const double end_s = at_s + random.uniform(5, 20);
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    const Vector2d along = random.uniform() * Vector2d(std::cos(angle), std::sin(angle));
    motions_.push_back({{at_s, end_s}, (gradients * along).transpose()});
    at_s = end_s;
  }
  for (int i = 0; i < std::lround(settings.minutes / 20); ++i) {
    steps_.push_back({random.uniform(0, seconds_), random.uniform(-1, 1) * largest_step});
  }
  const std::vector<ElectrodeSet> electrodes = electrode_sets_of_channels(sensor);
  for (int i = 0; i < std::max(1L, std::lround(settings.minutes / 10)); ++i) {
    Loose& one = loose_.emplace_back();
    one.begin_s = random.uniform(0.1 * seconds_, seconds_);
    one.end_s = one.begin_s + random.uniform(1, 5);
    const int electrode = random.integer(0, sensor.electrode_count - 1);
    for (std::size_t c = 0; c < electrodes.size(); ++c) {
      if (electrodes[c] >> electrode & 1) one.channels.push_back(static_cast<Eigen::Index>(c));
    }
  }
  draw_touches(sensor);
}

void ArmHour::draw_touches(const Sensor& sensor) {
  const BorderModel model(sensor);
  const Sheet& sheet = *sensor.sheet;
  RandomStream random(settings_.seed, hour_key, 0, Purpose::scene);
  bool any_long = false;
  for (double at_s = 10;; at_s = touches_.back().end_s) {
    HourTouch one;
    one.begin_s = at_s + random.uniform(3, 17);
    one.is_press = random.uniform() < 0.4;
    double seconds = one.is_press ? random.uniform(1, 10) : random.uniform(0.3, 1);
    if (one.is_press && !any_long && one.begin_s > 0.4 * seconds_) {
      any_long = true;
      seconds = seconds_ / 6;
    }
    one.end_s = one.begin_s + seconds;
    const double radius = one.is_press ? random.uniform(0.15, 0.3) : random.uniform(0.08, 0.15);
    const double ratio = one.is_press ? random.uniform(0.2, 0.6) : random.uniform(0.6, 0.8);
    const double angle = random.uniform(0, 2 * std::numbers::pi);
    // Uniform over a disc that keeps the contact on the sheet.
    const Vector2d from_middle = (0.97 * sheet.inner_radius() - radius) *
                                 std::sqrt(random.uniform()) *
                                 Vector2d(std::cos(angle), std::sin(angle));
    if (one.end_s >= seconds_) return;
    one.place_mm = sheet.unit_mm() * from_middle;
    const Scene scene{{arm_disc(sheet.bounds().center() + from_middle, radius, ratio)}};
    one.change = model.solve(scene, 1e-5 * reference_.norm()).change.transpose();
    touches_.push_back(std::move(one));
  }
}

Eigen::Index ArmHour::frames() const {
  return static_cast<Eigen::Index>(seconds_ * settings_.frame_rate);
}

double ArmHour::level(double time_s) const {
  double out = -drift_per_minute * time_s / minute_s;
  for (const Step& step : steps_) {
    out += step.level * std::clamp((time_s - step.at_s) / step_rise_s, 0.0, 1.0);
  }
  return out;
}

void ArmHour::frame(Eigen::Index frame, Eigen::Ref<Eigen::RowVectorXd> change) const {
  const double now_s = time_s(frame);
  change = reference_ + (1 - std::exp(-now_s / creep_s)) * creep_;
  for (const Motion& motion : motions_) {
    if (!motion.has(now_s)) continue;
    const double phase = (now_s - motion.begin_s) / (motion.end_s - motion.begin_s);
    const double there = std::sin(std::numbers::pi * phase);
    change += there * there * motion.change;
  }
  for (const HourTouch& touch : touches_) {
    const double there = there_at(now_s, touch.begin_s, touch.end_s);
    if (there > 0) change += there * touch.change;
  }
  change /= 1 + level(now_s);
  RandomStream random(settings_.seed, hour_key, static_cast<std::uint64_t>(frame), Purpose::noise);
  const double noise = rms_ * std::pow(10, -settings_.snr_db / 20);
  const double channel_s = 1 / (settings_.frame_rate * static_cast<double>(change.size()));
  for (Eigen::Index c = 0; c < change.size(); ++c) {
    const double cycles = mains_hz * (now_s + static_cast<double>(c) * channel_s);
    change[c] += noise * random.normal() +
                 std::numbers::sqrt2 * hum_share * rms_ * std::sin(2 * std::numbers::pi * cycles);
  }
  for (const Loose& loose : loose_) {
    if (loose.has(now_s)) change(loose.channels).setZero();
  }
  change -= reference_;
}

bool ArmHour::is_eventful(Eigen::Index frame) const {
  const double now_s = time_s(frame);
  const auto is_now = [&](const Span& span) { return span.has(now_s, near_s); };
  if (std::ranges::any_of(motions_, is_now) || std::ranges::any_of(loose_, is_now)) return true;
  return std::ranges::any_of(touches_, [&](const HourTouch& touch) {
    if (now_s < touch.begin_s - near_s || now_s > touch.end_s + near_s) return false;
    // Nothing comes or goes in the middle of a long press.
    return now_s < touch.begin_s + 10 || now_s > touch.end_s - near_s;
  });
}

HourJudge::HourJudge(const std::vector<HourTouch>& touches, double match_mm)
    : touches_(touches), match_mm_(match_mm), seen_(touches.size()) {}

void HourJudge::see(double time_s, std::span<const Vector2d> places_mm) {
  ++frames_;
  const auto touch = std::ranges::find_if(touches_, [&](const HourTouch& one) {
    return time_s >= one.begin_s && time_s <= one.end_s + tail_s;
  });
  std::optional<double> nearest_mm;
  bool false_alarm = false;
  for (const TrackPoint& track : tracker_.update(time_s, places_mm)) {
    if (!track.confirmed || !track.seen) continue;
    if (touch == touches_.end()) {
      false_alarm = true;
      continue;
    }
    const double distance_mm = (track.place_mm - touch->place_mm).norm();
    nearest_mm = std::min(nearest_mm.value_or(distance_mm), distance_mm);
    false_alarm = false_alarm || distance_mm > 2 * match_mm_;
  }
  if (touch != touches_.end() && time_s <= touch->end_s) {
    Seen& seen = seen_[static_cast<std::size_t>(touch - touches_.begin())];
    ++seen.frames;
    if (nearest_mm && *nearest_mm <= match_mm_) {
      ++seen.seen;
      seen.error_mm += *nearest_mm;
    }
  }
  if (false_alarm) alarm(time_s);
  before_s_ = time_s;
}

void HourJudge::alarm(double time_s) {
  if (alarms_ == 0 || time_s - alarm_end_s_ > alarm_pause_s) {
    ++alarms_;
    alarm_begin_s_ = time_s;
  }
  alarm_end_s_ = time_s;
  false_s_ += time_s - before_s_;
  if (!fails_s_ && time_s - alarm_begin_s_ > long_alarm_s) fails_s_ = time_s;
}

HourScores HourJudge::scores(double seconds) const {
  HourScores out;
  out.frames = frames_;
  int frames = 0;
  int seen_frames = 0;
  int detected = 0;
  double error_mm = 0;
  std::optional<double> fails_s = fails_s_;
  for (std::size_t t = 0; t < touches_.size(); ++t) {
    const HourTouch& touch = touches_[t];
    const Seen& seen = seen_[t];
    const bool missed = seen.seen == 0;
    ++(touch.is_press ? out.presses : out.touches);
    if (missed) ++(touch.is_press ? out.presses_missed : out.touches_missed);
    if (touch.is_press) {
      frames += seen.frames;
      seen_frames += seen.seen;
      if (missed) fails_s = std::min(fails_s.value_or(touch.end_s), touch.end_s);
    }
    if (missed) continue;
    ++detected;
    error_mm += seen.error_mm / seen.seen;
  }
  out.seen = frames > 0 ? static_cast<double>(seen_frames) / frames : 0;
  out.false_alarms = alarms_;
  out.false_alarms_h = alarms_ * 3600 / seconds;
  out.false_share = false_s_ / seconds;
  if (detected > 0) out.error_mm = error_mm / detected;
  if (fails_s) out.fails_min = *fails_s / minute_s;
  return out;
}

}  // namespace ertbench
