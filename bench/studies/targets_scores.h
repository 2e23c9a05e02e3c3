#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/contacts/contact_settings.h"
#include "bench/contacts/frame_reading.h"
#include "bench/score/contact_score.h"
#include "bench/studies/error_statistics.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What truly presses in a frame: the contacts whose centroids lie on the sheet.
struct TargetFrame {
  std::size_t scene = 0;  ///< frames of the same number show the same scene
  /// Whether the frame is one of those by which numbers of contacts are compared.
  bool counts = true;
  std::vector<Eigen::Vector2d> places_mm;  ///< from the sheet's centre
  std::vector<double> radii_mm;            ///< of the circles around the footprints

  int contacts() const { return static_cast<int>(places_mm.size()); }
  /// Between the two circles, to the millionth of a mm, so that gaps that were asked for are equal
  /// in all scenes; negative where they overlap. Nothing unless there are two contacts.
  std::optional<double> gap_mm() const;
};

TargetFrame target_frame(const Sensor& sensor, const Scene& scene, std::size_t number);

/// Clears `counts` of the frames of sets in which every frame has two contacts, where another set
/// has frames with two as well: such sets hold pairs at gaps of their own choice, which are
/// narrower or wider than those between three or four contacts. `sets` [frames] numbers their sets.
void leave_out_pair_sets(std::span<TargetFrame> frames, std::span<const std::size_t> sets);

/// Found contacts held against the true ones.
struct TargetMatch {
  std::vector<bool> right;  ///< [found] whether it belongs to a true contact; else it is a ghost
  ContactScore score;
};
TargetMatch match_targets(const TargetFrame& truth, std::span<const ContactReading> found,
                          const ContactDistances& distances);

/// Sums over frames.
struct TargetTally {
  int frames = 0;
  int right_frames = 0;  ///< with exactly as many contacts found as there are
  int there = 0;
  int found = 0;
  int matched = 0;
  double distance_mm = 0;
  double ospa_mm = 0;

  void add(const ContactScore& score);
  TargetTally& operator+=(const TargetTally& other);
};

/// A number by which solvers are compared; its sums are over all frames ("micro" averages), so that
/// a frame in which nothing was found has its part in it.
struct TargetMetric {
  std::string key;      ///< in summary.json: "precision"
  std::string heading;  ///< of its column, with the unit
  int decimals;
  std::optional<double> (*of)(const TargetTally&);  ///< nothing where nothing is divided
};

/// precision, recall, f1, ghosts, right_number, location_error_mm, ospa_mm.
const std::vector<TargetMetric>& target_metrics();

/// One solver's frames with the same number of true contacts.
struct TargetCount {
  int frames = 0;
  int scenes = 0;
  std::map<std::string, std::optional<Estimate>> metrics;  ///< all of target_metrics(), by key
};

/// By number of true contacts, over the frames with `counts` and a score. `scores` [frames]:
/// nothing where the solver did not get that far.
///
/// Intervals are the bootstrap's over scenes, the same scenes for every solver; resamples in which
/// a number is undefined do not enter. The share of frames with the right number has Wilson's
/// interval where every scene has one frame.
std::map<int, TargetCount> count_targets(std::span<const TargetFrame> frames,
                                         std::span<const std::optional<ContactScore>> scores);

}  // namespace ertbench
