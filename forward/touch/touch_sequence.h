#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/random.h"
#include "forward/touch/indenter.h"

namespace ertbench {

/// How a character is drawn with one finger.
struct Character {
  char symbol;
  /// In the order of drawing, each a polyline of points in mm, x to the right and y up, in the box
  /// [-60, 60] x [-60, 60]; between two strokes the finger is lifted.
  std::vector<std::vector<Eigen::Vector2d>> strokes;
};

/// The digits 0-9, then the letters A-Z, no two of one path: the zero is narrow and has a slash,
/// the O is round, the I has serifs.
const std::vector<Character>& characters();

/// One of characters(). Throws InputError naming those there are.
const Character& character(char symbol);

/// Where an indenter is at a moment and how hard it presses.
struct PathMoment {
  double time_s = 0;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  double force_N = 0;
};

/// An indenter that moves straight and evenly from point to point, times ascending; it does not
/// touch before the first and after the last.
struct TouchPath {
  Indenter indenter;
  std::vector<PathMoment> points;

  Touch at(double time_s) const;
};

/// What happens on a skin from time 0 on: a scene as a function of time.
struct TouchSequence {
  std::string name;  ///< what it is, for people: "A"; may be empty
  double duration_s = 0;
  std::vector<TouchPath> paths;

  /// The touches at a moment, one for each path, those without a force among them.
  std::vector<Touch> at(double time_s) const;
};

/// When the frames of a sequence are measured: drives one after the other, all voltages of a drive
/// at once. Frame n ends at (n + 1) / frame_rate, as a reader who waits for it would have it.
struct FrameTiming {
  double frame_rate = 125;       ///< 1/s
  double drive_time_s = 0.0005;  ///< of one drive, gap included; at most 1 / (drives frame_rate)

  double end_s(double frame) const { return (frame + 1) / frame_rate; }
  /// The middle of drive `drive` of `drives`.
  double drive_s(double frame, double drive, int drives) const {
    return end_s(frame) - (drives - drive - 0.5) * drive_time_s;
  }
  /// The middle of the frame's drives, for which its truth is given.
  double middle_s(double frame, int drives) const {
    return end_s(frame) - drives * drive_time_s / 2;
  }
};

class JsonObject;
struct Sensor;

/// The middle of each area of a sheet that is divided into areas x areas equal ones is pressed with
/// growing and then with falling force (D.2), each force held for a while: a sequence an area, the
/// areas of the first row (least y) first, and again from the first for as many repeats.
struct PressPlan {
  int areas = 5;  ///< along one side
  int repeats = 1;
  std::vector<double> forces_N = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};  ///< ascending
  double hold_s = 0.5;
  double ramp_s = 0.05;  ///< from one force to the next, a part of the hold
  double jitter_mm = 0;  ///< places are uniform in a square of twice this side
  Indenter indenter;

  /// The forces held, one after the other: up to the largest and down again.
  std::vector<double> steps() const;
};

/// A finger writes characters (D.4) at constant speed, the pen lifted between strokes: a sequence a
/// character, and again from the first for as many repeats.
struct WritePlan {
  std::string characters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";
  int repeats = 1;
  double speed_mm_s = 100;
  double size_mm = 120;  ///< of the box around a character
  double force_N = 2;
  double still_s = 0.1;  ///< on the sheet before and behind each stroke
  Indenter indenter{FlatFace{{8, 10}, 0, {}}};
};

/// Something is run into (D.5): nothing touches until a random moment, then the force grows evenly
/// at a random place, stays and goes.
struct CollidePlan {
  int sequences = 1;
  double duration_s = 1;
  double touched_fraction = 1;  ///< share of sequences in which anything touches
  std::pair<double, double> onset_s = {0.1, 0.2};
  std::pair<double, double> rate_N_s = {500, 2500};  ///< a speed times a stiffness
  std::pair<double, double> force_N = {10, 10};      ///< to which it grows
  double margin_mm = 10;                             ///< places are at least so far from the border
  Indenter indenter{Sphere{20}};
};

using SequencePlan = std::variant<PressPlan, WritePlan, CollidePlan>;

/// Sequences on a skin, each measured frame by frame.
class SequenceSet {
 public:
  SequenceSet(SequencePlan plan, FrameTiming timing);

  const SequencePlan& plan() const { return plan_; }
  const FrameTiming& timing() const { return timing_; }

  std::uint64_t sequences() const { return first_.size() - 1; }
  std::uint64_t frames() const { return first_.back(); }  ///< of all sequences
  std::uint64_t first_frame(std::uint64_t sequence) const { return first_[sequence]; }
  std::uint64_t frames_of(std::uint64_t sequence) const {
    return first_[sequence + 1] - first_[sequence];
  }
  std::uint64_t sequence_of(std::uint64_t frame) const;
  std::size_t most_touches() const { return 1; }  ///< at the same time

  /// `random` is keyed by the number of the sequence.
  TouchSequence draw(std::uint64_t sequence, RandomStream& random, const Sensor& sensor) const;

 private:
  SequencePlan plan_;
  FrameTiming timing_;
  std::vector<std::uint64_t> first_;  ///< frame of each sequence, and their count
};

/// Reads `{"sequence": "press" | "write" | "collide", ..., "indenter", "frame_rate",
/// "drive_time_ms"}`, the other keys being those of the plan. The sensor must have a skin.
SequenceSet sequence_set_from_json(JsonObject object, const Sensor& sensor);
nlohmann::json to_json(const SequenceSet& set);
nlohmann::ordered_json sequence_schema();

}  // namespace ertbench
