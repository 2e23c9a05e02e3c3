#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/score/image_contacts.h"
#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"

namespace ertbench {

/// The place of the one thing that moves, in each frame: the strongest contact's, absent in a frame
/// without any. mm from the sheet's origin.
using MeasuredPath = std::vector<std::optional<Eigen::Vector2d>>;
MeasuredPath path_of(std::span<const FrameReading> readings);

/// The middle of several methods' places in each frame, the medians of x and of y; absent where
/// fewer than two have one. All paths have as many frames.
MeasuredPath middle_path(std::span<const MeasuredPath> paths);

/// Scores of a method without any truth, on frames in which one thing of constant size moves.
/// Intervals: 95 %, by the bootstrap over blocks of consecutive frames. Absent where no frame has
/// the value.
struct ConsistencyScores {
  std::size_t frames = 0;
  std::size_t seen = 0;               ///< frames with a contact
  std::optional<Estimate> radius_mm;  ///< median radius of the disc of the contact's area
  // Half the range of the middle half of the frames, in normal deviations, over the median: what
  // the standard deviation over the mean is of normal values, whatever single frames do.
  std::optional<Estimate> radius_spread;
  std::optional<Estimate> amplitude_spread;  ///< of the image's sum
  std::optional<Estimate> peak_spread;
  std::optional<Estimate> step_mm;        ///< median step from frame to frame
  std::optional<Estimate> jerk_mm;        ///< median third difference of the path
  std::size_t outliers = 0;               ///< places far from the median of the frames around them
  std::optional<Estimate> more_contacts;  ///< mean number of contacts beyond the first
  std::optional<Estimate> explained;      ///< mean share of the change that the image explains
  std::optional<Estimate> apart_mm;       ///< median distance to the methods' middle
  std::size_t empty_frames = 0;           ///< frames with nothing on the sheet
  std::size_t false_contacts = 0;         ///< empty frames in which a contact is detected
  std::optional<double> latency_s;        ///< of the solver; not set by consistency_scores
};

struct ConsistencyInput {
  std::span<const FrameReading> moving;  ///< in the order of time
  std::span<const FrameReading> empty;
  std::span<const std::optional<Eigen::Vector2d>> middle;  ///< [moving] as middle_path has it
  double outlier_mm = 0;  ///< farther from the frames around it a place is an outlier
};

/// `key` names the intervals' random numbers.
ConsistencyScores consistency_scores(const ConsistencyInput& input, const std::string& key);

/// Measured frames without a truth: the spread of what should be constant, the smoothness of the
/// path, the share of the voltages that the image explains, the agreement of methods, and contacts
/// detected in empty frames.
Study consistency_study(const StudyInput& input);

}  // namespace ertbench
