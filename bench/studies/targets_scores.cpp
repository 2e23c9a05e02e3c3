#include "bench/studies/targets_scores.h"

#include <cmath>
#include <set>

#include "bench/contacts/assignment.h"
#include "bench/contacts/ospa.h"
#include "core/bootstrap.h"
#include "core/quantile.h"
#include "core/wilson_interval.h"

namespace ertbench {
namespace {

/// Of the circle around a contact's centroid that holds it, in the contact's unit.
double target_radius(const Contact& contact) {
  switch (contact.shape) {
    case Shape::disc:
    case Shape::ellipse:
      return contact.half_size.maxCoeff();
    case Shape::rectangle:
      return contact.half_size.norm();
    case Shape::polygon:
      break;
  }
  const Eigen::Vector2d middle = contact.centroid();
  double most = 0;
  for (const Eigen::Vector2d& vertex : contact.vertices) {
    most = std::max(most, (vertex - middle).norm());
  }
  return most;
}

std::optional<double> target_ratio(double part, double whole) {
  if (whole == 0) return std::nullopt;
  return part / whole;
}

std::optional<double> precision_of(const TargetTally& tally) {
  return target_ratio(tally.matched, tally.found);
}

std::optional<double> recall_of(const TargetTally& tally) {
  return target_ratio(tally.matched, tally.there);
}

/// The harmonic mean of precision and recall.
std::optional<double> f1_of(const TargetTally& tally) {
  return target_ratio(2.0 * tally.matched, tally.there + tally.found);
}

std::optional<double> ghosts_of(const TargetTally& tally) {
  return target_ratio(tally.found - tally.matched, tally.frames);
}

std::optional<double> right_number_of(const TargetTally& tally) {
  return target_ratio(tally.right_frames, tally.frames);
}

std::optional<double> location_error_of(const TargetTally& tally) {
  return target_ratio(tally.distance_mm, tally.matched);
}

std::optional<double> mean_ospa_of(const TargetTally& tally) {
  return target_ratio(tally.ospa_mm, tally.frames);
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

TargetMatch match_targets(const TargetFrame& truth, std::span<const ContactReading> found,
                          const ContactDistances& distances) {
  std::vector<Eigen::Vector2d> seen;
  for (const ContactReading& contact : found) seen.push_back(contact.place_mm);
  TargetMatch out;
  out.right.assign(seen.size(), false);
  out.score.there = truth.contacts();
  out.score.found = static_cast<int>(seen.size());
  const Eigen::MatrixXd apart = distances_between(truth.places_mm, seen);
  for (const auto& [row, column] : assign(apart, distances.match).pairs) {
    out.right[static_cast<std::size_t>(column)] = true;
    ++out.score.matched;
    out.score.distance_mm += apart(row, column);
  }
  out.score.ospa_mm = ospa(truth.places_mm, seen, distances.ospa);
  return out;
}

void TargetTally::add(const ContactScore& score) {
  ++frames;
  right_frames += score.found == score.there ? 1 : 0;
  there += score.there;
  found += score.found;
  matched += score.matched;
  distance_mm += score.distance_mm;
  ospa_mm += score.ospa_mm;
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
  static const std::vector<TargetMetric> metrics = {
      {"precision", "precision", 3, precision_of},
      {"recall", "recall", 3, recall_of},
      {"f1", "F1", 3, f1_of},
      {"ghosts", "ghosts a frame", 2, ghosts_of},
      {"right_number", "right number", 3, right_number_of},
      {"location_error_mm", "location error (mm)", 2, location_error_of},
      {"ospa_mm", "OSPA (mm)", 2, mean_ospa_of}};
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

}  // namespace ertbench
