#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/random.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {

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
  std::string characters;
  int repeats = 1;
  double speed_mm_s = 100;
  double size_mm = 120;  ///< of the box around a character
  double force_N = 2;
  double still_s = 0.1;  ///< on the sheet before and behind each stroke
  Indenter indenter;
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
  Indenter indenter;
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

}  // namespace ertbench
