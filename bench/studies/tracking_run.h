#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/contacts/path_distance.h"
#include "forward/touch/touch_sequence.h"

namespace ertbench {

/// A frame as a solver gets it, and what that found in it.
struct StreamFrame {
  double middle_s = 0;  ///< of its drives: the contacts' places are those of this time
  double end_s = 0;     ///< when all of its voltages are there
  std::vector<Eigen::Vector2d> contacts_mm;  ///< from the sheet's centre, the strongest first
};

/// What is known from a moment on, until the next report.
struct StreamReport {
  std::size_t frame = 0;  ///< that it is made from
  double out_s = 0;
  /// Where the finger was in the middle of the frame, if anywhere: the confirmed track that a
  /// contact of the frame belongs to, of several the oldest; in a frame without any contact the
  /// oldest confirmed track, where it should be by now.
  std::optional<Eigen::Vector2d> place_mm;
  std::vector<Eigen::Vector2d> seen_mm;  ///< of all confirmed tracks that the frame shows
};

/// Feeds the frames of a sequence, in their order, to a solver that takes `latency_s` for each and
/// to a tracker behind it. A frame that ends while the solver is busy waits; a newer one takes its
/// place. One report for each frame that was worked on.
std::vector<StreamReport> follow_stream(std::span<const StreamFrame> frames, double latency_s);

/// Reads characters by the nearest of forward/touch/characters.h (nearest_shape).
class CharacterReader {
 public:
  /// `size_mm`: of the box around a character.
  explicit CharacterReader(double size_mm);

  /// "A"; empty where no stroke has a point.
  std::string read(std::span<const Polyline> strokes) const;

 private:
  std::vector<Polyline> shapes_;
};

/// One written character, and what came of it. Values that are not defined are absent.
struct TrackedCharacter {
  std::string name;               ///< what was written
  std::vector<Polyline> written;  ///< [strokes] mm from the sheet's centre
  /// [strokes] the places reported of those frames in the middle of which the finger was down.
  std::vector<Polyline> tracked;

  // Of the places known at equally distant moments of the character, which are those of the latest
  // report, from where the finger is at the same moment, and from where it was `lag_s` before.
  std::optional<double> rms_mm;
  std::optional<double> rms_without_lag_mm;
  std::optional<double> lag_s;
  /// The largest of the strokes' discrete Fréchet distances; absent where a stroke has no place.
  std::optional<double> frechet_mm;
  std::string read_as;  ///< empty where nothing was tracked

  int frames = 0;
  int worked_on = 0;  ///< the others were dropped, as the solver was busy
  int touched = 0;    ///< of those worked on: the finger was down in the middle of the frame
  int lost = 0;       ///< of the touched ones: no place was reported
  /// Confirmed tracks that a frame showed while nothing touched during it, or farther than
  /// kGhostDistance from the finger; over all frames worked on.
  int ghosts = 0;

  bool read_back() const { return read_as == name; }
};

inline constexpr double kGhostDistance = 40;  ///< mm

/// Frames of the sequence `truth` as a solver of this latency gets them.
TrackedCharacter track_character(const TouchSequence& truth, std::span<const StreamFrame> frames,
                                 double latency_s, const CharacterReader& reader);

}  // namespace ertbench
