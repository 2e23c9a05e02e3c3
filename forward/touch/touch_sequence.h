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

/// A character as one finger draws it.
struct Character {
  char symbol;
  /// Polylines in the order of drawing, points in mm, x to the right and y up, in the box [-60, 60]
  /// x
  /// [-60, 60]. The finger is lifted between two strokes.
  std::vector<std::vector<Eigen::Vector2d>> strokes;
};

/// The digits 0-9, then the letters A-Z, all distinct: the zero is narrow and has a slash, the O is
/// round, the I has serifs.
const std::vector<Character>& characters();

/// Throws InputError with the known characters if `symbol` is none of them.
const Character& character(char symbol);

/// Position and force of an indenter at a moment.
struct PathMoment {
  double time_s = 0;
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();  ///< from the sheet's centre
  double force_N = 0;
};

/// An indenter that moves linearly from point to point, with ascending times. It does not touch
/// before the first point or after the last.
struct TouchPath {
  Indenter indenter;
  std::vector<PathMoment> points;

  Touch at(double time_s) const;
};

/// Touches of a skin from time 0 on.
struct TouchSequence {
  std::string name;  ///< for people: "A"; may be empty
  double duration_s = 0;
  std::vector<TouchPath> paths;

  /// The touches at a moment, one for each path, including those without a force.
  std::vector<Touch> at(double time_s) const;
};

/// Timing of the frames of a sequence: drives one after the other, all voltages of a drive at once.
/// Frame n ends at (n + 1) / frame_rate, when a reader receives it.
struct FrameTiming {
  double frame_rate = 125;       ///< 1/s
  double drive_time_s = 0.0005;  ///< one drive and its gap; at most 1 / (drives frame_rate)

  double end_s(double frame) const { return (frame + 1) / frame_rate; }
  /// The middle of drive `drive` of `drives`.
  double drive_s(double frame, double drive, int drives) const {
    return end_s(frame) - (drives - drive - 0.5) * drive_time_s;
  }
  /// The middle of the frame's drives, the time of its truth.
  double middle_s(double frame, int drives) const {
    return end_s(frame) - drives * drive_time_s / 2;
  }
};

class JsonObject;
struct Sensor;

/// Presses the middle of each of areas x areas equal areas of the sheet with growing and then
/// falling force (D.2), each force held for a while. One sequence per area, row by row from the
/// least y on, all of it `repeats` times.
struct PressPlan {
  int areas = 5;  ///< along one side
  int repeats = 1;
  std::vector<double> forces_N = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};  ///< ascending
  double hold_s = 0.5;
  double ramp_s = 0.05;  ///< from one force to the next, part of the hold
  double jitter_mm = 0;  ///< positions are uniform in a square with twice this side
  Indenter indenter;

  /// The held forces in order: up to the largest and down again.
  std::vector<double> steps() const;
};

/// A finger writes characters (D.4) at constant speed and is lifted between strokes. One sequence
/// per character, all of them `repeats` times.
struct WritePlan {
  std::string characters = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ";
  int repeats = 1;
  double speed_mm_s = 100;
  double size_mm = 120;  ///< of the box around a character
  double force_N = 2;
  double still_s = 0.1;  ///< at rest on the sheet before and after each stroke
  Indenter indenter{FlatFace{{8, 10}, 0, {}}};
};

/// A collision (D.5): no contact until a random moment, then the force at a random position grows
/// linearly and stays until the end.
struct CollidePlan {
  int sequences = 1;
  double duration_s = 1;
  double touched_fraction = 1;  ///< share of sequences with a contact
  std::pair<double, double> onset_s = {0.1, 0.2};
  std::pair<double, double> rate_N_s = {500, 2500};  ///< a speed times a stiffness
  std::pair<double, double> force_N = {10, 10};      ///< final force
  double margin_mm = 10;  ///< least distance of positions from the border
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
