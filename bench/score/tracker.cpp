#include "bench/score/tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bench/score/assignment.h"

namespace ertbench {
namespace {

constexpr double acceleration_mm_s2 = 5000;  ///< standard deviation along each axis
constexpr double measurement_mm = 3;  ///< standard deviation of a contact's place along each axis
constexpr double speed_mm_s = 500;    ///< standard deviation of a new contact's velocity, each axis
constexpr double gate_mm = 40;        ///< largest distance of a contact from a predicted position
constexpr int confirm_frames = 2;     ///< detections that confirm a new track ...
constexpr int confirm_window = 3;  ///< ... within this many frames from its first, or it is dropped
constexpr double patience_s = 0.1;  ///< a track ends after this time without a detection ...
constexpr int patience_frames = 2;  ///< ... and at least this many frames

}  // namespace

ConstantVelocity::ConstantVelocity(const Eigen::Vector2d& place_mm, double place_deviation_mm,
                                   double speed_deviation_mm_s)
    : state_(Eigen::Matrix2d::Zero()),
      covariance_(Eigen::Vector2d(place_deviation_mm, speed_deviation_mm_s)
                      .cwiseAbs2()
                      .asDiagonal()
                      .toDenseMatrix()) {
  state_.row(0) = place_mm;
}

void ConstantVelocity::predict(double step_s, double acceleration_deviation_mm_s2) {
  Eigen::Matrix2d motion = Eigen::Matrix2d::Identity();
  motion(0, 1) = step_s;
  const Eigen::Vector2d push =
      acceleration_deviation_mm_s2 * Eigen::Vector2d(step_s * step_s / 2, step_s);
  state_ = motion * state_;
  covariance_ = motion * covariance_ * motion.transpose() + push * push.transpose();
}

void ConstantVelocity::update(const Eigen::Vector2d& place_mm, double place_deviation_mm) {
  const Eigen::RowVector2d observation(1, 0);
  const double variance = place_deviation_mm * place_deviation_mm;
  const Eigen::Vector2d gain = covariance_ * observation.transpose() /
                               (observation * covariance_ * observation.transpose() + variance);
  state_ += gain * (place_mm.transpose() - observation * state_);
  // Joseph's form: symmetric and positive whatever the rounding.
  const Eigen::Matrix2d kept = Eigen::Matrix2d::Identity() - gain * observation;
  covariance_ = kept * covariance_ * kept.transpose() + variance * gain * gain.transpose();
}

std::vector<Eigen::Vector2d> centred_places_mm(std::span<const FoundContact> contacts,
                                               const Sheet& sheet) {
  std::vector<Eigen::Vector2d> out;
  for (const FoundContact& contact : contacts) {
    out.emplace_back(sheet.unit_mm() * (contact.place - sheet.bounds().center()));
  }
  return out;
}

std::vector<TrackPoint> Tracker::update(double time_s, std::span<const Eigen::Vector2d> places_mm) {
  if (!tracks_.empty() && !(time_s > time_s_)) {
    throw std::invalid_argument("a tracker's frames must be in the order of their times");
  }
  std::vector<Eigen::Vector2d> expected_mm;
  for (Track& track : tracks_) {
    track.motion.predict(time_s - time_s_, acceleration_mm_s2);
    expected_mm.push_back(track.motion.place_mm());
  }
  time_s_ = time_s;

  std::vector<const Eigen::Vector2d*> place_of(tracks_.size(), nullptr);
  std::vector<bool> taken(places_mm.size(), false);
  const Eigen::MatrixXd apart_mm = distances_between(expected_mm, places_mm);
  for (const auto& [track, place] : assign(apart_mm, gate_mm).pairs) {
    place_of[static_cast<std::size_t>(track)] = &places_mm[static_cast<std::size_t>(place)];
    taken[static_cast<std::size_t>(place)] = true;
  }
  for (std::size_t t = 0; t < tracks_.size(); ++t) take_in(tracks_[t], time_s, place_of[t]);
  std::erase_if(tracks_, [&](const Track& track) { return is_over(track, time_s); });
  for (std::size_t p = 0; p < places_mm.size(); ++p) {
    if (taken[p]) continue;
    tracks_.push_back({next_id_++, {places_mm[p], measurement_mm, speed_mm_s}, time_s});
  }

  std::vector<TrackPoint> points;
  for (const Track& track : tracks_) {
    points.push_back({track.id, track.motion.place_mm(), track.motion.velocity_mm_s(),
                      track.confirmed, track.frames_missed == 0});
  }
  return points;
}

void Tracker::take_in(Track& track, double time_s, const Eigen::Vector2d* place_mm) {
  ++track.frames;
  if (place_mm == nullptr) {
    ++track.frames_missed;
    return;
  }
  track.motion.update(*place_mm, measurement_mm);
  track.last_seen_s = time_s;
  track.frames_missed = 0;
  ++track.frames_seen;
  if (track.frames_seen >= confirm_frames) track.confirmed = true;
}

bool Tracker::is_over(const Track& track, double time_s) {
  // A new track is confirmed within its window or dropped at its end, so that counts suffice.
  if (!track.confirmed) return track.frames >= confirm_window;
  return track.frames_missed >= patience_frames && time_s - track.last_seen_s >= patience_s;
}

namespace {

constexpr double unreachable = std::numeric_limits<double>::infinity();

/// Least cost of an alignment from the first points of both lines to the last, by dynamic
/// programming. `first(distance)` is the cost at (0, 0); `step(distance, above, left, diagonal)`
/// computes the cost at (i, j) from those at (i - 1, j), (i, j - 1) and (i - 1, j - 1).
template <typename First, typename Step>
double cost_of_walk(const Polyline& a, const Polyline& b, First first, Step step) {
  if (a.empty() || b.empty()) throw std::invalid_argument("a path of no points has no distance");
  std::vector<double> costs(b.size(), unreachable);  // of row i - 1, then of row i from the left on
  for (std::size_t i = 0; i < a.size(); ++i) {
    double diagonal = unreachable;
    double left = unreachable;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const double above = costs[j];
      const double distance = (a[i] - b[j]).norm();
      costs[j] = i + j == 0 ? first(distance) : step(distance, above, left, diagonal);
      diagonal = above;
      left = costs[j];
    }
  }
  return costs.back();
}

}  // namespace

double length_of(const Polyline& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

Polyline resampled(const Polyline& line, double step) {
  if (line.empty() || !(step > 0)) {
    throw std::invalid_argument("only a path of points is resampled, and with a step > 0");
  }
  const double length = length_of(line);
  const auto pieces = static_cast<std::size_t>(std::ceil(length / step));
  Polyline out = {line.front()};
  std::size_t end = 1;    // end of the segment in which the next point lies
  double before_end = 0;  // length of the line up to that segment
  for (std::size_t piece = 1; piece < pieces; ++piece) {
    const double along = length * static_cast<double>(piece) / static_cast<double>(pieces);
    double size = (line[end] - line[end - 1]).norm();
    while (before_end + size < along && end + 1 < line.size()) {
      before_end += size;
      ++end;
      size = (line[end] - line[end - 1]).norm();
    }
    const double part = std::min((along - before_end) / size, 1.0);
    out.push_back(line[end - 1] + part * (line[end] - line[end - 1]));
  }
  if (pieces > 0) out.push_back(line.back());
  return out;
}

double frechet_distance(const Polyline& a, const Polyline& b) {
  return cost_of_walk(
      a, b, [](double distance) { return distance; },
      [](double distance, double above, double left, double diagonal) {
        return std::max(distance, std::min({above, left, diagonal}));
      });
}

double warped_distance(const Polyline& a, const Polyline& b) {
  const double sum = cost_of_walk(
      a, b, [](double distance) { return 2 * distance; },
      [](double distance, double above, double left, double diagonal) {
        return std::min(std::min(above, left) + distance, diagonal + 2 * distance);
      });
  return sum / static_cast<double>(a.size() + b.size());
}

Polyline centred_shape(std::span<const Polyline> strokes, double step) {
  Polyline out;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Polyline& stroke : strokes) {
    for (const Eigen::Vector2d& point : resampled(stroke, step)) {
      out.push_back(point);
      sum += point;
    }
  }
  for (Eigen::Vector2d& point : out) point -= sum / static_cast<double>(out.size());
  return out;
}

std::size_t nearest_shape(const Polyline& shape, std::span<const Polyline> shapes) {
  if (shapes.empty()) throw std::invalid_argument("there is no shape to be the nearest");
  std::size_t nearest = 0;
  double least = unreachable;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const double distance = warped_distance(shape, shapes[i]);
    if (distance >= least) continue;
    least = distance;
    nearest = i;
  }
  return nearest;
}

std::optional<double> rms_distance(std::span<const PathPoint> tracked, const TruePlace& truth,
                                   double lag_s) {
  double sum = 0;
  int points = 0;
  for (const PathPoint& point : tracked) {
    const std::optional<Eigen::Vector2d> place = truth(point.time_s - lag_s);
    if (!place) continue;
    sum += (point.place_mm - *place).squaredNorm();
    ++points;
  }
  if (points == 0) return std::nullopt;
  return std::sqrt(sum / points);
}

std::optional<LagFit> best_lag(std::span<const PathPoint> tracked, const TruePlace& truth,
                               double most_s, int steps) {
  if (steps < 2 || !(most_s > 0)) {
    throw std::invalid_argument("a lag is sought in a range, in 2 steps or more");
  }
  const double step = most_s / steps;
  const auto lag = [&](int i) { return step * i; };
  std::vector<PathPoint> shared;
  for (const PathPoint& point : tracked) {
    bool always = true;
    for (int i = 0; i <= steps && always; ++i) always = truth(point.time_s - lag(i)).has_value();
    if (always) shared.push_back(point);
  }
  if (shared.empty()) return std::nullopt;

  std::vector<double> squares;
  for (int i = 0; i <= steps; ++i) {
    const double rms = *rms_distance(shared, truth, lag(i));
    squares.push_back(rms * rms);
  }
  const auto best = std::ranges::min_element(squares);
  const int i = static_cast<int>(best - squares.begin());
  const LagFit scanned{lag(i), std::sqrt(*best)};
  if (i == 0 || i == steps) return scanned;
  const double curvature = best[-1] - 2 * best[0] + best[1];
  if (!(curvature > 0)) return scanned;
  const double refined = lag(i) + step * (best[-1] - best[1]) / (2 * curvature);
  const std::optional<double> rms = rms_distance(shared, truth, refined);
  return rms && *rms < scanned.rms_mm ? LagFit{refined, *rms} : scanned;
}

}  // namespace ertbench
