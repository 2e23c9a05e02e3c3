#include "bench/studies/consistency_scores.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/bootstrap.h"
#include "core/quantile.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

constexpr std::size_t frames_of_a_block = 10;  ///< neighbours in time are alike
constexpr std::size_t frames_around = 2;       ///< on each side, that an outlier is told by
constexpr double normal_half_range = 1.349;    ///< of the middle half of normal values

std::size_t blocks_of(std::size_t frames) {
  return std::max<std::size_t>(1, (frames + frames_of_a_block - 1) / frames_of_a_block);
}

double relative_spread(const std::vector<double>& values) {
  const SortedValues sorted = values;
  const double middle = std::abs(median(sorted));
  if (middle == 0) return 0;
  const double range = interpolated_quantile(sorted, 0.75) - interpolated_quantile(sorted, 0.25);
  return range / normal_half_range / middle;
}

/// The relative spread of values in their blocks.
std::optional<Estimate> spread_estimate(const std::vector<std::vector<double>>& blocks,
                                        const std::string& name) {
  std::vector<std::vector<double>> filled_blocks;
  std::vector<double> all;
  for (const std::vector<double>& block : blocks) {
    if (block.empty()) continue;
    filled_blocks.push_back(block);
    all.insert(all.end(), block.begin(), block.end());
  }
  if (all.size() < 2) return std::nullopt;
  const auto spread = [&](std::span<const std::size_t> drawn) {
    std::vector<double> values;
    for (const std::size_t b : drawn) {
      values.insert(values.end(), filled_blocks[b].begin(), filled_blocks[b].end());
    }
    return relative_spread(values);
  };
  return Estimate{relative_spread(all),
                  bootstrap_interval_of_groups(filled_blocks.size(), spread, name)};
}

/// Values of frames, kept by blocks.
class FrameValues {
 public:
  explicit FrameValues(std::size_t frames)
      : errors_(blocks_of(frames)), blocks_(blocks_of(frames)) {}

  void add(std::size_t frame, double value) {
    errors_.add(frame / frames_of_a_block, value);
    blocks_[frame / frames_of_a_block].push_back(value);
  }
  std::optional<Estimate> mean(const std::string& name) const { return errors_.mean(name); }
  std::optional<Estimate> median(const std::string& name) const {
    return errors_.quantile(0.5, name);
  }
  std::optional<Estimate> spread(const std::string& name) const {
    return spread_estimate(blocks_, name);
  }

 private:
  GroupedErrors errors_;
  std::vector<std::vector<double>> blocks_;
};

/// The medians of x and of y; at least one place.
Vector2d middle_of(const std::vector<Vector2d>& places) {
  std::vector<double> x;
  std::vector<double> y;
  for (const Vector2d& place : places) {
    x.push_back(place.x());
    y.push_back(place.y());
  }
  return {median(x), median(y)};
}

bool is_outlier(const MeasuredPath& path, std::size_t frame, double limit_mm) {
  std::vector<Vector2d> around;
  const std::size_t first = frame >= frames_around ? frame - frames_around : 0;
  for (std::size_t f = first; f < std::min(path.size(), frame + frames_around + 1); ++f) {
    if (f != frame && path[f]) around.push_back(*path[f]);
  }
  return around.size() >= 2 && (*path[frame] - middle_of(around)).norm() > limit_mm;
}

void score_path(const MeasuredPath& path, const ConsistencyInput& input, const std::string& key,
                ConsistencyScores& scores) {
  FrameValues steps(path.size());
  FrameValues jerks(path.size());
  FrameValues apart(path.size());
  for (std::size_t f = 0; f < path.size(); ++f) {
    if (!path[f]) continue;
    if (f >= 1 && path[f - 1]) steps.add(f, (*path[f] - *path[f - 1]).norm());
    if (f >= 3 && path[f - 1] && path[f - 2] && path[f - 3]) {
      jerks.add(f, (*path[f] - 3 * *path[f - 1] + 3 * *path[f - 2] - *path[f - 3]).norm());
    }
    if (input.middle[f]) apart.add(f, (*path[f] - *input.middle[f]).norm());
    if (is_outlier(path, f, input.outlier_mm)) ++scores.outliers;
  }
  scores.step_mm = steps.median(key + "step");
  scores.jerk_mm = jerks.median(key + "jerk");
  scores.apart_mm = apart.median(key + "apart");
}

}  // namespace

MeasuredPath path_of(std::span<const FrameReading> readings) {
  MeasuredPath path;
  for (const FrameReading& reading : readings) {
    path.push_back(reading.contacts.empty() ? std::nullopt
                                            : std::optional(reading.contacts.front().place_mm));
  }
  return path;
}

MeasuredPath middle_path(std::span<const MeasuredPath> paths) {
  MeasuredPath out(paths.empty() ? 0 : paths.front().size());
  for (std::size_t f = 0; f < out.size(); ++f) {
    std::vector<Vector2d> places;
    for (const MeasuredPath& path : paths) {
      if (path[f]) places.push_back(*path[f]);
    }
    if (places.size() >= 2) out[f] = middle_of(places);
  }
  return out;
}

ConsistencyScores consistency_scores(const ConsistencyInput& input, const std::string& key) {
  ConsistencyScores scores;
  scores.frames = input.moving.size();
  FrameValues radii(scores.frames);
  FrameValues amplitudes(scores.frames);
  FrameValues peaks(scores.frames);
  FrameValues more(scores.frames);
  FrameValues explained(scores.frames);
  for (std::size_t f = 0; f < scores.frames; ++f) {
    const FrameReading& reading = input.moving[f];
    if (reading.sum) amplitudes.add(f, *reading.sum);
    if (reading.peak) peaks.add(f, *reading.peak);
    if (reading.explained) explained.add(f, *reading.explained);
    if (reading.contacts.empty()) continue;
    ++scores.seen;
    radii.add(f, std::sqrt(reading.contacts.front().area_mm2 / std::numbers::pi));
    more.add(f, static_cast<double>(reading.contacts.size() - 1));
  }
  scores.radius_mm = radii.median(key + "radius");
  scores.radius_spread = radii.spread(key + "radius spread");
  scores.amplitude_spread = amplitudes.spread(key + "amplitude spread");
  scores.peak_spread = peaks.spread(key + "peak spread");
  scores.more_contacts = more.mean(key + "more");
  scores.explained = explained.mean(key + "explained");
  score_path(path_of(input.moving), input, key, scores);
  scores.empty_frames = input.empty.size();
  for (const FrameReading& reading : input.empty) {
    if (!reading.contacts.empty()) ++scores.false_contacts;
  }
  return scores;
}

}  // namespace ertbench
