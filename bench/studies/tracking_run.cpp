#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "bench/score/tracker.h"
#include "bench/studies/tracking.h"
#include "core/statistics.h"
#include "forward/touch/touch_sequence.h"

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

/// The stroke that is written at a time; nothing while the finger is up.
std::optional<std::size_t> stroke_at(const TouchSequence& truth, double time_s) {
  for (std::size_t s = 0; s < truth.paths.size(); ++s) {
    if (truth.paths[s].at(time_s).force_N > 0) return s;
  }
  return std::nullopt;
}

/// The finger's position, mm; nothing while it is up.
std::optional<Vector2d> finger_at(const TouchSequence& truth, double time_s) {
  const auto stroke = stroke_at(truth, time_s);
  if (!stroke) return std::nullopt;
  return truth.paths[*stroke].at(time_s).place_mm;
}

/// True if a track that a frame shows is a false positive. The drives at both ends of the frame
/// count too: a finger that is lifted during a frame is none.
bool is_false_positive(const TouchSequence& truth, const StreamFrame& frame,
                       const Vector2d& place_mm) {
  const double begin_s = 2 * frame.middle_s - frame.end_s;
  for (const double time_s : {begin_s, frame.middle_s, frame.end_s}) {
    const auto finger = finger_at(truth, time_s);
    if (finger && (place_mm - *finger).norm() <= kGhostDistance) return false;
  }
  return true;
}

/// Positions known at equally distant moments, each of them in the middle of its share of the time.
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
  StreamReport report;
  std::optional<Vector2d> unseen;
  for (const TrackPoint& track :
       tracker.update(frame.middle_s, frame.contacts_mm)) {  // the oldest first
    if (!track.confirmed) continue;
    if (track.seen) report.seen_mm.push_back(track.place_mm);
    if (!track.seen && !unseen) unseen = track.place_mm;
  }
  if (!report.seen_mm.empty()) report.place_mm = report.seen_mm.front();
  // A contact elsewhere says that the finger is no longer where it should be.
  if (frame.contacts_mm.empty()) report.place_mm = unseen;
  return report;
}

/// One character's terms of the two sums of a ratio.
struct RatioPart {
  double of = 0;
  double in = 0;
};

/// The sum of all `of` over the sum of all `in`.
std::optional<Estimate> ratio_over_characters(
    std::span<const TrackedCharacter> characters,
    const std::function<RatioPart(const TrackedCharacter&)>& part_of, const std::string& key) {
  std::map<std::string, RatioPart> by_name;
  for (const TrackedCharacter& character : characters) {
    const RatioPart part = part_of(character);
    if (part.in <= 0) continue;
    by_name[character.name].of += part.of;
    by_name[character.name].in += part.in;
  }
  if (by_name.empty()) return std::nullopt;
  std::vector<double> of;
  std::vector<double> in;
  for (const auto& [name, part] : by_name) {
    of.push_back(part.of);
    in.push_back(part.in);
  }
  const auto ratio = ratio_of_sums(of, in, key);
  return Estimate{ratio->ratio, ratio->ci95};
}

/// Mean over the characters that have the value, times `factor`; counts them in `count`.
std::optional<Estimate> mean_over_characters(std::span<const TrackedCharacter> characters,
                                             std::optional<double> TrackedCharacter::*value,
                                             double factor, int& count, const std::string& key) {
  count = static_cast<int>(std::ranges::count_if(
      characters, [&](const TrackedCharacter& one) { return (one.*value).has_value(); }));
  return ratio_over_characters(
      characters,
      [&](const TrackedCharacter& one) {
        return one.*value ? RatioPart{factor * *(one.*value), 1} : RatioPart{};
      },
      key);
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
    out.ghosts +=
        static_cast<int>(std::ranges::count_if(report.seen_mm, [&](const Vector2d& place) {
          return is_false_positive(truth, frame, place);
        }));
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
  if (const auto fit = best_lag(known, finger, most_s, lag_steps)) {
    out.rms_without_lag_mm = fit->rms_mm;
    out.lag_s = fit->lag_s;
  }
  out.frechet_mm = frechet_of_strokes(out);
  out.read_as = reader.read(out.tracked);
  return out;
}

TrackingScores tracking_scores(std::span<const TrackedCharacter> characters,
                               const std::string& key) {
  TrackingScores out;
  if (characters.empty()) return out;
  const auto mean_of = [&](std::optional<double> TrackedCharacter::*value, double factor,
                           int& count, const char* name) {
    return mean_over_characters(characters, value, factor, count, key + " " + name);
  };
  out.rms_mm = mean_of(&TrackedCharacter::rms_mm, 1, out.with_rms, "rms");
  out.rms_without_lag_mm =
      mean_of(&TrackedCharacter::rms_without_lag_mm, 1, out.with_lag, "rms without lag");
  out.lag_ms = mean_of(&TrackedCharacter::lag_s, 1000, out.with_lag, "lag");
  out.frechet_mm = mean_of(&TrackedCharacter::frechet_mm, 1, out.with_frechet, "Fréchet");
  const auto ratio_of = [&](auto of, auto in, const char* name) {
    return ratio_over_characters(
        characters,
        [&](const TrackedCharacter& one) {
          return RatioPart{static_cast<double>(of(one)), static_cast<double>(in(one))};
        },
        key + " " + name);
  };
  using One = TrackedCharacter;
  out.drop_outs = ratio_of([](const One& one) { return one.lost; },
                           [](const One& one) { return one.touched; }, "drop-outs");
  out.dropped_frames = ratio_of([](const One& one) { return one.frames - one.worked_on; },
                                [](const One& one) { return one.frames; }, "dropped");
  out.ghosts = ratio_of([](const One& one) { return one.ghosts; },
                        [](const One& one) { return one.worked_on; }, "ghosts");
  const auto read =
      static_cast<int>(std::ranges::count_if(characters, std::mem_fn(&One::read_back)));
  const auto all = static_cast<int>(characters.size());
  out.read_back = Estimate{static_cast<double>(read) / all, wilson_interval(read, all)};
  return out;
}

std::optional<double> enough_frame_rate(std::span<const RateValue> rates, bool most_is_best) {
  constexpr double within = 0.05;
  std::optional<double> best;
  for (const RateValue& one : rates) {
    if (!one.value) continue;
    if (!best || (most_is_best ? *one.value > *best : *one.value < *best)) best = one.value;
  }
  if (!best || (most_is_best && *best <= 0)) return std::nullopt;
  const double limit = *best * (most_is_best ? 1 - within : 1 + within);
  std::optional<double> least;
  for (const RateValue& one : rates) {
    if (!one.value || (most_is_best ? *one.value < limit : *one.value > limit)) continue;
    least = std::min(least.value_or(one.frame_rate), one.frame_rate);
  }
  return least;
}

std::vector<EnoughFrameRate> enough_frame_rates(std::span<const TrackingCondition> conditions) {
  std::vector<EnoughFrameRate> out;
  if (conditions.empty()) return out;
  std::map<std::pair<std::string, double>, std::vector<const TrackingCondition*>> alike;
  for (const TrackingCondition& one : conditions) {
    alike[{one.noise, one.speed_mm_s}].push_back(&one);
  }
  for (std::size_t s = 0; s < conditions.front().solvers.size(); ++s) {
    for (const auto& [which, group] : alike) {
      std::set<double> tried;
      std::vector<RateValue> shares;
      std::vector<RateValue> distances;
      for (const TrackingCondition* one : group) {
        const TrackingScores& scores = one->solvers[s].scores;
        tried.insert(one->frame_rate);
        shares.push_back({one->frame_rate, value_of(scores.read_back)});
        distances.push_back({one->frame_rate, value_of(scores.rms_mm)});
      }
      if (tried.size() < 2) continue;
      out.push_back({conditions.front().solvers[s].label,
                     which.second,
                     which.first,
                     {tried.begin(), tried.end()},
                     enough_frame_rate(shares, true),
                     enough_frame_rate(distances, false)});
    }
  }
  return out;
}

}  // namespace ertbench
