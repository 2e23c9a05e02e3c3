#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "forward/touch/indenter.h"

namespace ertbench {

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

}  // namespace ertbench
