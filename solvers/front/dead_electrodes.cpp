// Which electrodes of a frame are dead: read zero, float, are loose or half dead.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

#include "solvers/front/frame_check.h"

namespace ertbench {
namespace {

constexpr double unlike = 9;            ///< square of a pair's difference, of the usual noise's
constexpr double few_pairs_more = 1.5;  ///< fewer pairs scatter more
constexpr int least_torn = 5;  ///< pairs of a loose electrode; it has 13, one beside others fewer
constexpr int left_over = 2;   ///< such pairs that need no explanation
/// Half-dead electrodes: their pairs' readings of the reference, their pairs at least, pairs that
/// need no explanation.
constexpr double half_from = 0.25;
constexpr double half_to = 0.75;
constexpr int least_halved = 8;
constexpr int halved_left_over = 6;
/// The largest factor of their readings, and the share of their pairs that it explains to 20 %. A
/// good conductor beside an electrode takes more from some of its channels than from others.
constexpr double halved_at_most = 0.66;
constexpr double halved_share = 0.6;
constexpr double like_halved = 0.2;

/// The fewest electrodes that are in all of the `sets` but `spared`, found one after the other,
/// each in `least` of those that are left; none if they are more than FrameCheck::most_masked.
ElectrodeSet explaining(const std::vector<ElectrodeSet>& sets, int least, int spared) {
  const auto unexplained = [&](ElectrodeSet by) {
    return std::count_if(sets.begin(), sets.end(), [&](ElectrodeSet set) { return !(set & by); });
  };
  ElectrodeSet found = 0;
  while (unexplained(found) > spared) {
    std::array<int, 64> votes{};
    for (const ElectrodeSet set : sets) {
      for (ElectrodeSet left = set & found ? 0 : set; left != 0; left &= left - 1) {
        ++votes[static_cast<std::size_t>(std::countr_zero(left))];
      }
    }
    const auto most = std::max_element(votes.begin(), votes.end());
    if (*most < least || size_of(found) == 2 * FrameCheck::most_masked) return 0;
    found |= ElectrodeSet{1} << (most - votes.begin());
  }
  // One between two others may have been named first.
  for (ElectrodeSet left = found; left != 0; left &= left - 1) {
    const ElectrodeSet without = found & ~(left & -left);
    if (unexplained(without) <= spared) found = without;
  }
  return size_of(found) <= FrameCheck::most_masked ? found : 0;
}

}  // namespace

template <typename Bad>
ElectrodeSet FrameCheck::with_bad_pairs(Bad&& bad) const {
  std::vector<int> count(static_cast<std::size_t>(electrode_count_), 0);
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if (!bad(pairs_[p])) continue;
    for (std::size_t e = 0; e < count.size(); ++e) {
      if (pair_electrodes_[p] >> e & 1) ++count[e];
    }
  }
  ElectrodeSet found = 0;
  for (std::size_t e = 0; e < count.size(); ++e) {
    if (count[e] > 0 && count[e] >= least_bad_[e]) found |= ElectrodeSet{1} << e;
  }
  return found;
}

ElectrodeSet FrameCheck::reading_zero(const double* change) const {
  const Eigen::Map<const Eigen::ArrayXd> frame(change, reference_.size());
  const auto zeros = (frame + reference_).abs() <= nearly_zero_;
  if (zeros.count() < fewest_bad_) return 0;
  const auto is_zero = [&](int c) {
    return std::abs(change[c] + reference_[c]) <= nearly_zero_[c];
  };
  return with_bad_pairs([&](const auto& pair) { return is_zero(pair[0]) && is_zero(pair[1]); });
}

void FrameCheck::find_loose(const double* change, double usual, Verdict& verdict) const {
  const Eigen::Map<const Eigen::ArrayXd> frame(change, reference_.size());
  const auto zeros = (frame + reference_).abs() <= nearly_zero_;
  if (zeros.count() < least_torn) return;
  std::vector<ElectrodeSet> torn;  // electrodes of pairs of which one channel alone reads zero
  double differences = 0;          // of the others
  int doubles = 0;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const auto [a, b] = pairs_[p];
    const auto reads = [&](int c) {
      return std::abs(frame[c] + reference_[c]) > 3 * nearly_zero_[c];
    };
    if ((zeros[a] && reads(b)) || (zeros[b] && reads(a))) {
      torn.push_back(pair_electrodes_[p]);
    } else {
      differences += square(frame[a] - frame[b]) / 2;
      doubles += a != b;
    }
  }
  verdict.dead = explaining(torn, least_torn, left_over);
  verdict.torn = verdict.dead != 0 || (torn.size() >= static_cast<std::size_t>(least_torn) &&
                                       differences <= few_pairs_more * doubles * usual);
}

void FrameCheck::find_half_dead(const Eigen::Ref<const Eigen::VectorXd>& means,
                                Verdict& verdict) const {
  const auto reference = [&](Eigen::Index p) { return reference_size_ * along_reference_[p]; };
  const auto is_halved = [&](Eigen::Index p) {
    const double square_of = square(reference(p));
    const double along = means[p] * reference(p) + square_of;
    return along > half_from * square_of && along < half_to * square_of;
  };
  int halved = 0;
  for (Eigen::Index p = 0; p < means.size(); ++p) halved += is_halved(p);
  if (halved < 2 * least_halved) return;
  std::vector<ElectrodeSet> sets;
  for (Eigen::Index p = 0; p < means.size(); ++p) {
    if (is_halved(p)) sets.push_back(pair_electrodes_[static_cast<std::size_t>(p)]);
  }
  const ElectrodeSet found = explaining(sets, least_halved, halved_left_over);
  std::vector<bool> lost(pairs_.size());
  for (std::size_t p = 0; p < lost.size(); ++p) lost[p] = (pair_electrodes_[p] & found) != 0;
  Eigen::VectorXd given = means;
  if (found == 0 || !condition(given, lost)) return;
  double usual = 0;
  double product = 0;
  const auto for_lost = [&](auto&& see) {
    for (Eigen::Index p = 0; p < given.size(); ++p) {
      if (lost[static_cast<std::size_t>(p)]) see(given[p] + reference(p), means[p] + reference(p));
    }
  };
  for_lost([&](double expected, double reading) {
    usual += square(expected);
    product += expected * reading;
  });
  const double share = product / usual;
  if (share < half_from || share > halved_at_most) return;
  double count = 0;
  double like = 0;
  for_lost([&](double expected, double reading) {
    count += 1;
    like += std::abs(reading - share * expected) < like_halved * share * std::abs(expected);
  });
  if (like < halved_share * count) return;
  verdict.dead = found;
  verdict.lost_share = 1 - share;
}

double FrameCheck::usual_noise(double signal) const {
  return (noise_.a + noise_.b * signal) * noise_.limit / std::max(1, doubles_);
}

ElectrodeSet FrameCheck::floating(const double* change, double signal) const {
  const double most = unlike * usual_noise(signal);
  return with_bad_pairs(
      [&](const auto& pair) { return square(change[pair[0]] - change[pair[1]]) / 2 > most; });
}

bool FrameCheck::noisy_without(const double* change, ElectrodeSet dead, int least) const {
  double differences = 0;
  double signal = 0;
  int left = 0;
  int left_doubles = 0;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    if (pair_electrodes_[p] & dead) continue;
    const auto& [a, b] = pairs_[p];
    const double mean = (change[a] + change[b]) / std::numbers::sqrt2;
    const double reference = reference_size_ * along_reference_[static_cast<Eigen::Index>(p)];
    differences += square(change[a] - change[b]) / 2;
    signal += square(noise_of_change_ ? mean : mean + reference);
    ++left;
    left_doubles += a != b;
  }
  if (left < least) return true;
  signal *= static_cast<double>(pairs_.size()) / std::max(left, 1);
  // The channels of a dead electrode may have been the strong ones.
  if (!noise_of_change_) signal = std::max(signal, square(reference_size_));
  return differences > few_pairs_more * left_doubles * usual_noise(signal);
}

/// Removes every second electrode from each run of dead ones, where both neighbours are dead.
ElectrodeSet FrameCheck::fewest(ElectrodeSet dead) const {
  if (!drives_neighbours_) return dead;
  const int count = electrode_count_;
  const auto is_dead = [&](int e) { return dead >> ((e + count) % count) & 1; };
  int begin = 0;  // start of a run, if not all electrodes are dead
  while (begin < count && !(is_dead(begin) && !is_dead(begin - 1))) ++begin;
  for (int e = begin; e < begin + count; ++e) {
    if (is_dead(e - 1) && is_dead(e) && is_dead(e + 1)) dead &= ~(ElectrodeSet{1} << e % count);
  }
  return dead;
}

}  // namespace ertbench
