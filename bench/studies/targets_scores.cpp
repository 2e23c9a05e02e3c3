#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bench/plot/panel.h"
#include "bench/studies/targets.h"
#include "core/statistics.h"
#include "core/text.h"

namespace ertbench {
namespace {

/// Radius of the circle around a contact's centroid that holds it, in the contact's unit.
double target_radius(const Contact& contact) {
  if (contact.shape == Shape::rectangle) return contact.half_size.norm();
  if (contact.shape != Shape::polygon) return contact.half_size.maxCoeff();
  const Eigen::Vector2d middle = contact.centroid();
  double most = 0;
  for (const Eigen::Vector2d& vertex : contact.vertices) {
    most = std::max(most, (vertex - middle).norm());
  }
  return most;
}

/// `scenes` is not empty. `name` keys the random numbers.
TargetCount target_count(const std::vector<TargetTally>& scenes, const std::string& name) {
  TargetTally all;
  for (const TargetTally& scene : scenes) all += scene;
  const auto& metrics = target_metrics();
  // All numbers are made from the same resamples, so one round of them serves all.
  std::vector<std::vector<double>> resampled(metrics.size());
  bootstrap_interval_of_groups(
      scenes.size(),
      [&](std::span<const std::size_t> drawn) {
        TargetTally sum;
        for (const std::size_t scene : drawn) sum += scenes[scene];
        for (std::size_t m = 0; m < metrics.size(); ++m) {
          if (const auto value = metrics[m].of(sum)) resampled[m].push_back(*value);
        }
        return 0.0;
      },
      name);

  TargetCount out;
  out.frames = all.frames;
  out.scenes = static_cast<int>(scenes.size());
  for (std::size_t m = 0; m < metrics.size(); ++m) {
    std::optional<Estimate>& estimate = out.metrics[metrics[m].key];
    const std::optional<double> value = metrics[m].of(all);
    if (!value) continue;
    const SortedValues values = std::move(resampled[m]);
    estimate = {*value,
                {interpolated_quantile(values, 0.025), interpolated_quantile(values, 0.975)}};
  }
  if (out.frames == out.scenes) {
    out.metrics["right_number"]->ci95 = wilson_interval(all.right_frames, all.frames);
  }
  return out;
}

/// The gap at which a fit reaches kResolvedShare; nothing where it does not.
std::optional<double> gap_reached(const std::vector<IsotonicBlock>& fit) {
  // The slack lets a share of 4 in 5 count, whatever the rounding of its mean.
  const auto resolves = [](const IsotonicBlock& b) { return b.value >= kResolvedShare - 1e-9; };
  const auto reached = std::ranges::find_if(fit, resolves);
  double scenes = 0;
  for (auto block = reached; block != fit.end(); ++block) scenes += block->weight;
  if (scenes < kLeastResolvedScenes) return std::nullopt;
  if (reached == fit.begin()) return reached->first;
  const IsotonicBlock& before = *std::prev(reached);
  const double share = (kResolvedShare - before.value) / (reached->value - before.value);
  return before.last + share * (reached->first - before.last);
}

std::vector<WeightedPoint> gap_points(std::span<const GapTrial> trials) {
  std::vector<WeightedPoint> points;
  for (const GapTrial& trial : trials) points.push_back({trial.gap_mm, trial.share(), 1});
  return points;
}

ResolvableGap resolvable_gap(std::span<const GapTrial> trials) {
  using State = ResolvableGap::State;
  ResolvableGap out;
  if (trials.size() < kLeastResolvedScenes) return out;
  const double least = trials.front().gap_mm;
  const double largest = trials.back().gap_mm;
  std::vector<WeightedPoint> points = gap_points(trials);
  out.gap_mm = gap_reached(isotonic_fit(points));
  out.state = !out.gap_mm ? State::never : *out.gap_mm <= least ? State::always : State::resolved;

  // A resample that resolves nothing stands beyond the set, at its largest gap.
  const Interval interval = bootstrap_interval_of_groups(
      trials.size(),
      [&](std::span<const std::size_t> drawn) {
        for (WeightedPoint& point : points) point.weight = 0;
        for (const std::size_t trial : drawn) points[trial].weight += 1;
        return gap_reached(isotonic_fit(points)).value_or(largest);
      },
      "resolvable gap");
  if (interval.low > least) out.low_mm = interval.low;
  if (interval.high < largest) out.high_mm = interval.high;
  return out;
}

Estimate told_apart_in(const std::vector<GapTrial>& trials) {
  double sum = 0;
  bool single = true;
  int told_apart = 0;
  std::vector<double> shares;
  for (const GapTrial& trial : trials) {
    sum += trial.share();
    single = single && trial.frames == 1;
    told_apart += trial.told_apart;
    shares.push_back(trial.share());
  }
  const auto count = static_cast<int>(trials.size());
  return {sum / count, single ? wilson_interval(told_apart, count)
                              : bootstrap_interval_of_mean(shares, "told apart")};
}

/// About ten bins of round width for nine tenths of the scenes; if the few widest gaps reach far
/// beyond those, they share the last.
std::vector<GapBin> gap_bins(std::span<const GapTrial> trials) {
  std::vector<double> gaps;
  for (const GapTrial& trial : trials) gaps.push_back(trial.gap_mm);
  const double usual = interpolated_quantile(gaps, 0.9);
  const double span = usual - gaps.front();
  const double step = span > 0 ? round_step(span, 10) : 1;
  // The slack keeps a gap of 0.3 out of the bin that ends there.
  const auto number_of = [&](double gap) { return std::lround(std::floor(gap / step + 1e-9)); };
  const long last = number_of(usual) + 1;
  const long end = number_of(gaps.back()) + 1;

  std::map<long, std::vector<GapTrial>> filled;
  for (const GapTrial& trial : trials) {
    filled[std::min(number_of(trial.gap_mm), last)].push_back(trial);
  }
  std::vector<GapBin> bins;
  for (const auto& [number, members] : filled) {
    GapBin bin;
    bin.low_mm = step * static_cast<double>(number);
    bin.high_mm = step * static_cast<double>(number == last ? end : number + 1);
    bin.scenes = static_cast<int>(members.size());
    for (const GapTrial& trial : members) bin.mean_gap_mm += trial.gap_mm / bin.scenes;
    bin.told_apart = told_apart_in(members);
    bins.push_back(bin);
  }
  return bins;
}

}  // namespace

std::optional<double> TargetFrame::gap_mm() const {
  if (places_mm.size() != 2) return std::nullopt;
  const double gap = (places_mm[0] - places_mm[1]).norm() - radii_mm[0] - radii_mm[1];
  return std::round(1e6 * gap) / 1e6;
}

TargetFrame target_frame(const Sensor& sensor, const Scene& scene, std::size_t number) {
  TargetFrame out;
  out.scene = number;
  const double mm = sensor.sheet->unit_mm();
  for (const Contact& contact : scene.contacts) {
    const Eigen::Vector2d place = contact.centroid();
    if (sensor.sheet->depth(place) < 0) continue;
    out.places_mm.emplace_back(mm * place);
    out.radii_mm.push_back(mm * target_radius(contact));
  }
  return out;
}

void leave_out_pair_sets(std::span<TargetFrame> frames, std::span<const std::size_t> sets) {
  std::set<std::size_t> mixed;
  std::set<std::size_t> with_pairs;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    (frames[f].contacts() == 2 ? with_pairs : mixed).insert(sets[f]);
  }
  bool elsewhere = false;
  for (const std::size_t set : with_pairs) elsewhere = elsewhere || mixed.contains(set);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    frames[f].counts = !elsewhere || mixed.contains(sets[f]);
  }
}

ContactScore match_targets(const TargetFrame& truth, std::span<const ContactReading> found,
                           const ContactDistances& distances) {
  std::vector<Eigen::Vector2d> seen;
  for (const ContactReading& contact : found) seen.push_back(contact.place_mm);
  return score_places(truth.places_mm, seen, distances);
}

void TargetTally::add(const ContactScore& score) {
  *this += {1,
            score.found == score.true_count,
            score.true_count,
            score.found,
            score.matched,
            score.distance_mm,
            score.ospa_mm};
}

TargetTally& TargetTally::operator+=(const TargetTally& other) {
  frames += other.frames;
  right_frames += other.right_frames;
  there += other.there;
  found += other.found;
  matched += other.matched;
  distance_mm += other.distance_mm;
  ospa_mm += other.ospa_mm;
  return *this;
}

const std::vector<TargetMetric>& target_metrics() {
  using Tally = TargetTally;
  static const std::vector<TargetMetric> metrics = {
      {"precision", "precision", 3,
       [](const Tally& t) { return ratio_or_none(t.matched, t.found); }},
      {"recall", "recall", 3, [](const Tally& t) { return ratio_or_none(t.matched, t.there); }},
      {"f1", "F1", 3,
       [](const Tally& t) { return ratio_or_none(2.0 * t.matched, t.there + t.found); }},
      {"ghosts", "false positives a frame", 2,
       [](const Tally& t) { return ratio_or_none(t.found - t.matched, t.frames); }},
      {"right_number", "right number", 3,
       [](const Tally& t) { return ratio_or_none(t.right_frames, t.frames); }},
      {"location_error_mm", "localisation error (mm)", 2,
       [](const Tally& t) { return ratio_or_none(t.distance_mm, t.matched); }},
      {"ospa_mm", "OSPA (mm)", 2,
       [](const Tally& t) { return ratio_or_none(t.ospa_mm, t.frames); }}};
  return metrics;
}

std::map<int, TargetCount> count_targets(std::span<const TargetFrame> frames,
                                         std::span<const std::optional<ContactScore>> scores) {
  std::map<int, std::map<std::size_t, TargetTally>> tallies;  // by number of contacts and scene
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (!frames[f].counts || !scores[f]) continue;
    tallies[frames[f].contacts()][frames[f].scene].add(*scores[f]);
  }
  std::map<int, TargetCount> out;
  for (const auto& [contacts, by_scene] : tallies) {
    std::vector<TargetTally> scenes;
    for (const auto& [scene, tally] : by_scene) scenes.push_back(tally);
    out[contacts] = target_count(scenes, "targets of " + std::to_string(contacts) + " contacts");
  }
  return out;
}

std::vector<GapTrial> gap_trials(std::span<const TargetFrame> frames,
                                 std::span<const std::optional<ContactScore>> scores) {
  std::map<std::size_t, GapTrial> by_scene;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const std::optional<double> gap = frames[f].gap_mm();
    if (!gap || !scores[f]) continue;
    GapTrial& trial = by_scene[frames[f].scene];
    trial.gap_mm = *gap;
    ++trial.frames;
    trial.told_apart += scores[f]->matched == 2 ? 1 : 0;
  }
  std::vector<GapTrial> trials;
  for (const auto& [scene, trial] : by_scene) trials.push_back(trial);
  std::ranges::stable_sort(trials, {}, &GapTrial::gap_mm);
  return trials;
}

TargetGaps measure_gaps(std::span<const GapTrial> trials) {
  TargetGaps out;
  if (trials.empty()) return out;
  out.scenes = static_cast<int>(trials.size());
  out.least_mm = trials.front().gap_mm;
  out.largest_mm = trials.back().gap_mm;
  out.bins = gap_bins(trials);
  out.resolvable = resolvable_gap(trials);
  return out;
}

std::string ResolvableGap::text() const {
  if (state == State::resolved) return fixed(*gap_mm, 1);
  return state == State::always ? "≤ " + fixed(*gap_mm, 1) : name_of(state);
}

std::string ResolvableGap::interval() const {
  if (state == State::too_few_pairs) return "";
  return interval_text(low_mm ? fixed(*low_mm, 1) : "< set",
                       high_mm ? fixed(*high_mm, 1) : "> set");
}

const char* name_of(ResolvableGap::State state) {
  constexpr const char* names[] = {"resolved", "at the least gap already", "not within the set",
                                   "too few pairs"};
  return names[static_cast<std::size_t>(state)];
}

}  // namespace ertbench
