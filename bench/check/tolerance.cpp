#include "bench/check/tolerance.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/statistics.h"

namespace ertbench {
namespace {

constexpr double rounding = 1e-10;
constexpr double linear_images = 1e-8;
constexpr double confidence = 0.999;

/// A gap leaves the image within about sqrt(gap) of the optimum, as the objective grows with the
/// square of the distance; within a third of that where it was measured (pdipm). The means over the
/// frames of the quick experiment differ by up to 2e-4 between gaps of 1e-4 and 1e-8, and by 4e-13
/// between builds with and without FMA and AVX: a tenth of sqrt(gap), 1e-3 for the default, has
/// room for test sets of few frames.
double of_duality_gap(const ResultRow& row) {
  const double gap = row.parameters->value("tolerance", 1e-4);
  return 0.1 * std::sqrt(gap);
}

/// Largest effect of one contact more or less on a frame's value: one for counts and shares, a
/// quarter of the sheet's side, OSPA's cut-off, for distances.
double one_contact(const BaselineMean& before) {
  const bool length = entry_of(before.metric).quantity == Quantity::millimetres;
  return length ? before.sensor.sheet->size_mm().maxCoeff() / 4 : 1;
}

/// Effect of one pixel that crosses a threshold on the mean over the frames.
double one_pixel(const BaselineMean& before) {
  const double frames = std::max(1, before.frames);
  const double pixels = before.sensor.image().count_on_sheet();
  switch (entry_of(before.metric).threshold) {
    case Threshold::none:
      return 0;
    case Threshold::area:
      return 100 / (std::sqrt(pixels) * frames);
    case Threshold::centroid: {
      const double share = 1 - before.resolution.value_or(100) / 100;  // (C2)
      const double bright_pixels = 1 + pixels * share * share;
      const double diagonal = 2 * before.sensor.sheet->radius();
      return diagonal / (2 * bright_pixels * frames);
    }
    case Threshold::contact:
      return one_contact(before) / frames;
  }
  return 0;
}

/// Twice the rank of each value, so that ties get whole numbers.
std::vector<std::size_t> doubled_ranks(std::span<const double> values) {
  std::vector<std::size_t> out;
  for (const double value : values) {
    std::size_t below = 0;
    std::size_t equal = 0;
    for (const double other : values) {
      below += other < value;
      equal += other == value;
    }
    out.push_back(2 * below + equal + 1);
  }
  return out;
}

/// The smallest probability of a rank sum of `now` of `all` values: that of a single choice.
double smallest_chance(std::size_t now, std::size_t all) {
  double choices = 1;
  for (std::size_t i = 1; i <= now; ++i) {
    choices *= static_cast<double>(all - now + i) / static_cast<double>(i);
  }
  return 1 / choices;
}

}  // namespace

Tolerance tolerance_of(const ResultRow& row, std::optional<ImageComparison> images) {
  if (!images) return {ToleranceClass::exact, rounding};
  if (*images == ImageComparison::seeds) return {ToleranceClass::seeds, stored_image_tolerance};
  if (*images == ImageComparison::duality_gap) {
    return {ToleranceClass::interior_point, of_duality_gap(row)};
  }
  return {ToleranceClass::linear,
          row.parameters->contains("checkpoint") ? stored_image_tolerance : linear_images};
}

double centre_of(std::span<const double> values) { return mean(values); }

double seeds_interval(int seeds_before, int seeds_now) {
  const double t = student_t_quantile(0.5 + confidence / 2, seeds_before - 1);
  return t * std::sqrt(1.0 / std::max(1, seeds_now) + 1.0 / seeds_before);
}

double allowed_change(const Tolerance& tolerance, const BaselineMean& before, int seeds_now) {
  const double centre = std::abs(centre_of(before.values));
  if (tolerance.type == ToleranceClass::seeds && before.values.size() > 1) {
    const auto n = static_cast<int>(before.values.size());
    const double deviation = std::max(sample_deviation(before.values), tolerance.relative * centre);
    return deviation * seeds_interval(n, seeds_now) +
           (entry_of(before.metric).of_contacts() ? one_pixel(before) : 0);
  }
  const double pixel = tolerance.type == ToleranceClass::exact ? 0 : one_pixel(before);
  return std::max(tolerance.relative * centre,
                  std::min(tolerance.relative, linear_images) *
                      typical_magnitude(entry_of(before.metric).quantity)) +
         pixel;
}

double rank_sum_chance(std::span<const double> before, std::span<const double> now) {
  std::vector<double> all(now.begin(), now.end());
  all.insert(all.end(), before.begin(), before.end());
  const std::vector<std::size_t> ranks = doubled_ranks(all);
  const auto first = ranks.begin();
  const auto sum =
      std::accumulate(first, first + static_cast<std::ptrdiff_t>(now.size()), std::size_t{0});
  // choices[k][s]: of k of the values so far whose doubled ranks sum up to s.
  const std::size_t most = std::accumulate(ranks.begin(), ranks.end(), std::size_t{0});
  std::vector<std::vector<double>> choices(now.size() + 1, std::vector<double>(most + 1, 0.0));
  choices[0][0] = 1;
  for (const std::size_t rank : ranks) {
    for (std::size_t k = now.size(); k > 0; --k) {
      for (std::size_t s = rank; s <= most; ++s) choices[k][s] += choices[k - 1][s - rank];
    }
  }
  const std::vector<double>& sums = choices[now.size()];
  const auto at = sums.begin() + static_cast<std::ptrdiff_t>(sum);
  const double below = std::accumulate(sums.begin(), at + 1, 0.0);
  const double above = std::accumulate(at, sums.end(), 0.0);
  return std::min(below, above) / std::accumulate(sums.begin(), sums.end(), 0.0);
}

bool is_beyond(const Tolerance& tolerance, const BaselineMean& before, const TodaysMean& now) {
  const double change = std::abs(now.mean - centre_of(before.values));
  if (change <= allowed_change(tolerance, before, now.trainings())) return false;
  const bool ranked = tolerance.type == ToleranceClass::seeds && before.values.size() > 1 &&
                      now.seeds.size() > 1 && entry_of(before.metric).of_contacts();
  if (!ranked) return true;
  std::vector<double> values;
  for (const std::optional<double>& value : now.seeds) {
    if (!value || !std::isfinite(*value)) return true;  // that training has no mean at all
    values.push_back(*value);
  }
  const double least = smallest_chance(values.size(), values.size() + before.values.size());
  // The sums of the distribution are rounded.
  return rank_sum_chance(before.values, values) <= std::max((1 - confidence) / 2, 1.0001 * least);
}

}  // namespace ertbench
