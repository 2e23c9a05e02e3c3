#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <vector>

#include "bench/run/stage.h"
#include "bench/score/tracker.h"
#include "bench/studies/study.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// Settings of a simulated time on the arm.
struct HourSettings {
  double minutes = 60;
  double frame_rate = 100;  ///< 1/s
  double snr_db = 50;       ///< of the voltages of the untouched sheet
  std::uint64_t seed = 1;
};

/// One contact of the arm's time; never two at once.
struct HourTouch {
  double begin_s = 0;
  double end_s = 0;
  bool is_press = false;                               ///< else a light touch
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  Eigen::RowVectorXd change;                           ///< [channels] V, of the exact model
};

/// The time of a robot's skin, drawn from a seed: its sheet drifts by 0.1 % a minute and steps with
/// the temperature, its foam creeps (the response of a broad disc that grows by itself), the arm
/// moves (gradients that come and go), electrodes come loose for seconds and read zero, the mains
/// hum, and light touches and presses come one after another, the first late press for a sixth of
/// the time.
///
/// Contacts are exact scenes; they, the creep and the gradients add up linearly.
class ArmHour {
 public:
  ArmHour(const Sensor& sensor, const HourSettings& settings);

  Eigen::Index frames() const;
  double time_s(Eigen::Index frame) const {
    return static_cast<double>(frame) / settings_.frame_rate;
  }
  /// Change from the reference taken at the beginning, [channels] V; the same in any order.
  void frame(Eigen::Index frame, Eigen::Ref<Eigen::RowVectorXd> change) const;
  /// False where nothing happens: nothing begins, ends or comes and goes within half a second.
  bool is_eventful(Eigen::Index frame) const;
  const std::vector<HourTouch>& touches() const { return touches_; }

 private:
  struct Span {
    double begin_s = 0;
    double end_s = 0;
    bool has(double time_s, double margin_s = 0) const {
      return time_s >= begin_s - margin_s && time_s <= end_s + margin_s;
    }
  };
  struct Motion : Span {
    Eigen::RowVectorXd change;  ///< [channels] V at its greatest
  };
  struct Loose : Span {
    std::vector<Eigen::Index> channels;
  };
  struct Step {
    double at_s = 0;
    double level = 0;
  };

  void draw_touches(const Sensor& sensor);
  double level(double time_s) const;

  HourSettings settings_;
  double seconds_ = 0;
  Eigen::RowVectorXd reference_;  ///< [channels] V
  double rms_ = 0;                ///< of the reference, V
  Eigen::RowVectorXd creep_;      ///< [channels] V, when it has ended
  std::vector<HourTouch> touches_;
  std::vector<Motion> motions_;
  std::vector<Loose> loose_;
  std::vector<Step> steps_;
};

/// What a method made of the time.
struct HourScores {
  bool follows = false;  ///< the reference was followed while nothing pressed (QuietReference)
  int frames = 0;        ///< that were reconstructed
  int touches = 0;
  int touches_missed = 0;
  int presses = 0;
  int presses_missed = 0;
  double seen = 0;                  ///< share of the presses' frames in which they were seen
  int false_alarms = 0;             ///< a pause of a second ends one
  double false_alarms_h = 0;        ///< an hour
  double false_share = 0;           ///< of the time
  std::optional<double> error_mm;   ///< mean over the contacts that were detected
  std::optional<double> fails_min;  ///< end of the first missed press, or a false alarm of a second
};

/// Judges the contacts that a method detects, through a tracker.
class HourJudge {
 public:
  /// `match_mm`: a track this close to a contact is it; a false alarm is twice as far from any.
  HourJudge(const std::vector<HourTouch>& touches, double match_mm);

  /// Adds the contacts of a frame, mm from the sheet's centre; times rise.
  void see(double time_s, std::span<const Eigen::Vector2d> places_mm);
  HourScores scores(double seconds) const;

 private:
  struct Seen {
    int frames = 0;
    int seen = 0;
    double error_mm = 0;  ///< sum
  };
  void alarm(double time_s);

  const std::vector<HourTouch>& touches_;
  double match_mm_;
  Tracker tracker_;
  std::vector<Seen> seen_;
  int frames_ = 0;
  double before_s_ = 0;  ///< time of the frame before
  int alarms_ = 0;
  double alarm_begin_s_ = 0;
  double alarm_end_s_ = 0;
  double false_s_ = 0;
  std::optional<double> fails_s_;
};

/// Runs every solver through the time of each study "arm_hour", with and without following the
/// reference.
std::unique_ptr<Stage> arm_hour_stage();
Study arm_hour_study(const StudyInput& input);

}  // namespace ertbench
