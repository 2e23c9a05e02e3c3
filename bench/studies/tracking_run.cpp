#include "bench/studies/tracking_run.h"

#include <algorithm>
#include <limits>

#include "bench/contacts/tracker.h"
#include "forward/touch/characters.h"

namespace ertbench {
namespace {

using Eigen::Vector2d;

constexpr double drawn_size_mm = 120;  ///< of the box of characters()
constexpr double shape_step_mm = 4;    ///< between points of shapes that are compared
constexpr double frechet_step_mm = 2;
constexpr int known_moments = 500;  ///< of a character, at which its error is taken
constexpr int lag_steps = 50;
/// Beyond the latency and the time between two reports: what a frame, the tracker and the foam add.
constexpr double most_further_lag_s = 0.1;
/// Times that are equal but for rounding.
constexpr double same_time_s = 1e-9;

/// Where the finger is, mm; nothing while it is up.
std::optional<Vector2d> finger_at(const TouchSequence& truth, double time_s) {
  for (const TouchPath& path : truth.paths) {
    const Touch touch = path.at(time_s);
    if (touch.force_N > 0) return touch.place_mm;
  }
  return std::nullopt;
}

/// The stroke that is written at a time; nothing while the finger is up.
std::optional<std::size_t> stroke_at(const TouchSequence& truth, double time_s) {
  for (std::size_t s = 0; s < truth.paths.size(); ++s) {
    if (truth.paths[s].at(time_s).force_N > 0) return s;
  }
  return std::nullopt;
}

/// Whether a track that a frame shows is none of the finger's. What the drives at both ends of the
/// frame saw counts too: a finger that is lifted during a frame is no ghost in it.
bool is_ghost(const TouchSequence& truth, const StreamFrame& frame, const Vector2d& place_mm) {
  const double begin_s = 2 * frame.middle_s - frame.end_s;
  for (const double time_s : {begin_s, frame.middle_s, frame.end_s}) {
    const auto finger = finger_at(truth, time_s);
    if (finger && (place_mm - *finger).norm() <= kGhostDistance) return false;
  }
  return true;
}

/// What is known at equally distant moments, each of them in the middle of its share of the time.
std::vector<PathPoint> known_places(std::span<const StreamReport> reports, double duration_s) {
  std::vector<PathPoint> known;
  std::size_t out = 0;  // reports that are out
  for (int moment = 0; moment < known_moments; ++moment) {
    const double time_s = duration_s * (moment + 0.5) / known_moments;
    while (out < reports.size() && reports[out].out_s <= time_s) ++out;
    if (out == 0 || !reports[out - 1].place_mm) continue;
    known.push_back({time_s, *reports[out - 1].place_mm});
  }
  return known;
}

double longest_pause_s(std::span<const StreamReport> reports) {
  double longest = 0;
  for (std::size_t i = 1; i < reports.size(); ++i) {
    longest = std::max(longest, reports[i].out_s - reports[i - 1].out_s);
  }
  return longest;
}

std::optional<double> frechet_of_strokes(const TrackedCharacter& character) {
  std::optional<double> largest;
  for (std::size_t s = 0; s < character.written.size(); ++s) {
    if (character.tracked[s].empty()) return std::nullopt;
    const double distance = frechet_distance(resampled(character.written[s], frechet_step_mm),
                                             resampled(character.tracked[s], frechet_step_mm));
    largest = std::max(largest.value_or(0), distance);
  }
  return largest;
}

StreamReport report_of_frame(const StreamFrame& frame, Tracker& tracker) {
  std::vector<TimedContact> contacts;
  for (const Vector2d& place : frame.contacts_mm) contacts.push_back({place});
  StreamReport report;
  std::optional<Vector2d> unseen;
  for (const TrackPoint& track : tracker.update(frame.middle_s, contacts)) {  // the oldest first
    if (!track.confirmed) continue;
    if (track.seen) report.seen_mm.push_back(track.place_mm);
    if (!track.seen && !unseen) unseen = track.place_mm;
  }
  if (!report.seen_mm.empty()) report.place_mm = report.seen_mm.front();
  // A contact elsewhere says that the finger is no longer where it should be.
  if (frame.contacts_mm.empty()) report.place_mm = unseen;
  return report;
}

}  // namespace

std::vector<StreamReport> follow_stream(std::span<const StreamFrame> frames, double latency_s) {
  std::vector<StreamReport> reports;
  Tracker tracker;
  double free_s = -std::numeric_limits<double>::infinity();  // when the solver has nothing to do
  for (std::size_t next = 0; next < frames.size(); ++next) {
    while (next + 1 < frames.size() && frames[next + 1].end_s <= free_s + same_time_s) ++next;
    StreamReport report = report_of_frame(frames[next], tracker);
    free_s = std::max(free_s, frames[next].end_s) + latency_s;
    report.frame = next;
    report.out_s = free_s;
    reports.push_back(std::move(report));
  }
  return reports;
}

CharacterReader::CharacterReader(double size_mm) {
  for (const Character& character : characters()) {
    std::vector<Polyline> strokes = character.strokes;
    for (Polyline& stroke : strokes) {
      for (Vector2d& point : stroke) point *= size_mm / drawn_size_mm;
    }
    shapes_.push_back(centred_shape(strokes, shape_step_mm));
  }
}

std::string CharacterReader::read(std::span<const Polyline> strokes) const {
  std::vector<Polyline> drawn;
  for (const Polyline& stroke : strokes) {
    if (!stroke.empty()) drawn.push_back(stroke);
  }
  if (drawn.empty()) return "";
  const std::size_t nearest = nearest_shape(centred_shape(drawn, shape_step_mm), shapes_);
  return {characters()[nearest].symbol};
}

TrackedCharacter track_character(const TouchSequence& truth, std::span<const StreamFrame> frames,
                                 double latency_s, const CharacterReader& reader) {
  TrackedCharacter out;
  out.name = truth.name;
  for (const TouchPath& path : truth.paths) {
    out.written.emplace_back();
    for (const PathMoment& moment : path.points) out.written.back().push_back(moment.place_mm);
  }
  out.tracked.resize(out.written.size());

  const std::vector<StreamReport> reports = follow_stream(frames, latency_s);
  out.frames = static_cast<int>(frames.size());
  out.worked_on = static_cast<int>(reports.size());
  for (const StreamReport& report : reports) {
    const StreamFrame& frame = frames[report.frame];
    out.ghosts += static_cast<int>(
        std::count_if(report.seen_mm.begin(), report.seen_mm.end(),
                      [&](const Vector2d& place) { return is_ghost(truth, frame, place); }));
    const auto stroke = stroke_at(truth, frame.middle_s);
    if (!stroke) continue;
    ++out.touched;
    if (report.place_mm) out.tracked[*stroke].push_back(*report.place_mm);
    if (!report.place_mm) ++out.lost;
  }

  const TruePlace finger = [&](double time_s) { return finger_at(truth, time_s); };
  const std::vector<PathPoint> known = known_places(reports, truth.duration_s);
  out.rms_mm = rms_distance(known, finger, 0);
  const double most_s = latency_s + longest_pause_s(reports) + most_further_lag_s;
  if (const auto fit = best_lag(known, finger, 0, most_s, lag_steps)) {
    out.rms_without_lag_mm = fit->rms_mm;
    out.lag_s = fit->lag_s;
  }
  out.frechet_mm = frechet_of_strokes(out);
  out.read_as = reader.read(out.tracked);
  return out;
}

}  // namespace ertbench
