#include "solvers/front/frame_check.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/errors.h"
#include "core/statistics.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/decompositions.h"
#include "solvers/front/front_numbers.h"

namespace ertbench {

namespace {

void require_frames(Eigen::Index count) {
  if (count == 0) throw std::invalid_argument("there are no frames to take a limit from");
}

}  // namespace

double tail_limit(Eigen::VectorXd values, double share) {
  require_frames(values.size());
  std::sort(values.begin(), values.end(), std::greater<>());
  const Eigen::Index farthest = std::max<Eigen::Index>(values.size() / 10, 1);
  if (values.size() <= farthest || values[farthest] <= 0) return values[0];
  const double begin = values[farthest];
  const double seen = values[static_cast<Eigen::Index>(share * static_cast<double>(values.size()))];
  const Eigen::ArrayXd logarithms = (values.head(farthest).array() / begin).log();
  const double first = logarithms.mean();
  const double second = logarithms.square().mean();
  if (!(second > first * first)) return values[0];
  const double bounded = std::min(0.0, 1 - 0.5 / (1 - first * first / second));
  const double exponent = first + bounded;
  const double farther =
      std::log(static_cast<double>(farthest) / static_cast<double>(values.size()) / share);
  // (farther^exponent - 1) / exponent, a logarithm for the exponent 0.
  const double reach =
      std::abs(exponent) < 1e-9 ? farther : std::expm1(exponent * farther) / exponent;
  return std::max(begin * (1 + first * (1 - bounded) * reach), seen);
}

UsualLevel UsualLevel::of(const Eigen::VectorXd& q, const Eigen::VectorXd& s, double floor,
                          double share) {
  require_frames(q.size());
  // Least squares with relative errors, reweighted by the level of the last pass.
  UsualLevel level{std::max(q.mean(), floor), 0, 0};
  for (int i = 0; i < 10; ++i) {
    const Eigen::ArrayXd w = (level.a + level.b * s.array()).square().inverse();
    const double ww = w.sum();
    const double ws = (w * s.array()).sum();
    const double wss = (w * s.array().square()).sum();
    const double wq = (w * q.array()).sum();
    const double wqs = (w * q.array() * s.array()).sum();
    const double determinant = ww * wss - ws * ws;
    level.b = determinant > 1e-12 * ww * wss ? (ww * wqs - ws * wq) / determinant : 0;
    level.b = std::max(level.b, 0.0);
    level.a = (wq - level.b * ws) / ww;
    if (level.a < floor) {
      level.a = floor;
      level.b = wss > 0 ? std::max(0.0, (wqs - floor * ws) / wss) : 0;
    }
  }
  level.limit = tail_limit((q.array() / (level.a + level.b * s.array())).matrix(), share);
  // A lower level would raise alarms by less than the converter resolves.
  level.limit = std::max(level.limit, 1.0);
  return level;
}

PrincipalDirections PrincipalDirections::of(const Eigen::MatrixXd& frames, double noise) {
  require_frames(frames.rows());
  PrincipalDirections out;
  out.mean = frames.colwise().mean().transpose();
  const Eigen::MatrixXd centred = frames.rowwise() - out.mean.transpose();
  const SymmetricEigen eigen =
      symmetric_eigen(centred.transpose() * centred /
                      static_cast<double>(std::max<Eigen::Index>(frames.rows() - 1, 1)));
  const auto above = (eigen.values.array() >= 2 * noise).count();
  const Eigen::Index count = std::min({above, most, frames.rows() / 4});
  out.rows = eigen.vectors.rightCols(count).transpose();
  out.inverse_power = eigen.values.tail(count).cwiseInverse();
  out.tilt = out.inverse_power.cwiseProduct(out.rows * out.mean);
  return out;
}

namespace {

constexpr double tail_share = 1.0 / 1200;  ///< of good frames beyond each limit
constexpr std::uint64_t most_frames = 4096;
constexpr std::uint64_t least_frames = 100;
constexpr Eigen::Index folds = 4;
/// Noise below this share of the reference voltages' root mean square is ignored.
constexpr double resolution = 1e-6;
constexpr double zero = 0.1;  ///< of the reference voltage
/// Share of bad pairs that makes an electrode dead. A live electrode beside a dead one, with three
/// more dead ones elsewhere, has 20 bad pairs of 26.
constexpr double bad_share = 0.83;
constexpr double unlike = 9;            ///< square of a pair's difference, of the usual noise's
constexpr double few_pairs_more = 1.5;  ///< fewer pairs scatter more
/// Ratio of fits at which noise counts as following the change rather than the frame.
constexpr double much_closer = 0.8;
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
constexpr Eigen::Index stack_pairs = 256;

double square(double x) { return x * x; }

/// The fewest electrodes that are in all of the `sets` but `left_over`, found one after the other,
/// each in `least` of those that are left; none if they are more than FrameCheck::most_masked.
ElectrodeSet explaining(const std::vector<ElectrodeSet>& sets, int least, int left_over) {
  const auto unexplained = [&](ElectrodeSet by) {
    return std::count_if(sets.begin(), sets.end(), [&](ElectrodeSet set) { return !(set & by); });
  };
  ElectrodeSet found = 0;
  while (unexplained(found) > left_over) {
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
    if (unexplained(without) <= left_over) found = without;
  }
  return size_of(found) <= FrameCheck::most_masked ? found : 0;
}

double upper_median_of(const Eigen::ArrayXd& values) {
  return upper_median(std::vector<double>(values.begin(), values.end()));
}

Frames read_changes(const FitInput& input) {
  const DatasetFile* set = input.validation ? input.validation : input.training;
  if (!set) return {};
  if (set->sensor() != input.sensor) {
    throw InputError(set->path().string() + ": is of another sensor; generate it for this one");
  }
  const Frames voltages = set->voltages(0, std::min(most_frames, set->size()));
  return voltages.rowwise() - set->reference_voltages().transpose();
}

}  // namespace

int least_bad_pairs(std::ptrdiff_t pairs) {
  return static_cast<int>(std::ceil(bad_share * static_cast<double>(pairs)));
}

FrameCheck::FrameCheck(const Sensor& sensor, ElectrodeSet masked) {
  set_sensor(sensor, masked);
  set_reference(uniform_reference(sensor));
}

FrameCheck::FrameCheck(const FitInput& input, ElectrodeSet masked) {
  set_sensor(input.sensor, masked);
  const DatasetFile* set = input.validation ? input.validation : input.training;
  set_reference(set ? set->reference_voltages() : uniform_reference(input.sensor));
  const Frames changes = read_changes(input);
  if (changes.rows() >= static_cast<Eigen::Index>(least_frames) && !pairs_.empty()) fit(changes);
}

void FrameCheck::set_sensor(const Sensor& sensor, ElectrodeSet masked) {
  electrode_count_ = sensor.electrode_count;
  doubles_ = 0;
  drives_neighbours_ = sensor.is_adjacent();
  const auto all_pairs = reciprocal_pairs(sensor);
  const auto electrodes = electrodes_of_pairs(sensor);
  for (const Eigen::Index kept : pairs_without(sensor, masked)) {
    const auto p = static_cast<std::size_t>(kept);
    pairs_.push_back(all_pairs[p]);
    doubles_ += all_pairs[p][0] != all_pairs[p][1];
    pair_electrodes_.push_back(electrodes[p]);
  }
  fewest_bad_ = sensor.channels();
  for (int e = 0; e < electrode_count_; ++e) {
    const auto used = std::count_if(pair_electrodes_.begin(), pair_electrodes_.end(),
                                    [e](ElectrodeSet set) { return set >> e & 1; });
    least_bad_.push_back(least_bad_pairs(used));
    if (used > 0) fewest_bad_ = std::min(fewest_bad_, least_bad_.back());
  }
}

void FrameCheck::set_reference(const Eigen::VectorXd& reference) {
  reference_ = reference.array();
  nearly_zero_ = zero * reference_.abs();
  along_reference_.resize(static_cast<Eigen::Index>(pairs_.size()));
  split(reference_.data(), along_reference_.data());
  reference_size_ = along_reference_.norm();
  along_reference_ /= reference_size_;
}

double FrameCheck::split(const double* change, double* means) const {
  double differences = 0;
  for (const auto& [a, b] : pairs_) {
    *means++ = (change[a] + change[b]) * (1 / std::numbers::sqrt2);
    differences += square(change[a] - change[b]);
  }
  return differences / 2;
}

void FrameCheck::fit(const Frames& changes) {
  const Eigen::Index count = changes.rows();
  const auto pairs = static_cast<Eigen::Index>(pairs_.size());
  RowMajorMatrix shapes(count, pairs);
  Eigen::VectorXd differences(count);
  for (Eigen::Index f = 0; f < count; ++f) {
    differences[f] = split(changes.row(f).data(), shapes.row(f).data());
  }
  const Eigen::VectorXd signal = shapes.rowwise().squaredNorm();
  const Eigen::VectorXd frames =
      (shapes.rowwise() + reference_size_ * along_reference_.transpose()).rowwise().squaredNorm();
  const double floor = square(resolution * reference_size_);
  noise_ = UsualLevel::of(differences, frames, floor, tail_share);
  const UsualLevel of_change = UsualLevel::of(differences, signal, floor, tail_share);
  noise_of_change_ = of_change.limit < much_closer * noise_.limit;
  if (noise_of_change_) noise_ = of_change;

  const double usual_noise = std::max(upper_median_of(differences), floor);
  least_size_ = 4 * usual_noise;
  const Eigen::ArrayXd squares = signal.array() + least_size_;
  shapes.array().colwise() /= squares.sqrt();
  const double noise = usual_noise / std::max(1, doubles_) / upper_median_of(squares);
  Eigen::VectorXd outside(count);
  Eigen::VectorXd distance(count);
  Eigen::ArrayXd along(count);
  for (Eigen::Index fold = 0; fold < folds; ++fold) {
    std::vector<Eigen::Index> others;
    for (Eigen::Index f = 0; f < count; ++f) {
      if (f % folds != fold) others.push_back(f);
    }
    const auto directions = PrincipalDirections::of(shapes(others, Eigen::all), noise);
    for (Eigen::Index f = fold; f < count; f += folds) {
      const Eigen::VectorXd centred = shapes.row(f).transpose() - directions.mean;
      const auto place = directions.place(centred);
      outside[f] = place.outside * squares[f];
      distance[f] = place.distance;
      along[f] = place.along;
    }
  }
  directions_ = PrincipalDirections::of(shapes, noise);
  outside_ = UsualLevel::of(outside, signal, floor, tail_share);
  farthest_ = tail_limit(distance, tail_share);
  largest_ = tail_limit(signal, tail_share);
  const double middle = upper_median_of(along);
  highest_ = middle + tail_limit((along - middle).max(0.0), tail_share);
  lowest_ = middle - tail_limit((middle - along).max(0.0), tail_share);
}

void FrameCheck::widen(const Frames& changes) {
  if (!has_limits() || changes.rows() < static_cast<Eigen::Index>(least_frames)) return;
  FrameCheck usual = *this;
  usual.flagging_.reset();
  usual.fit(changes);
  flagging_ = std::make_shared<const FrameCheck>(std::move(usual));
}

FrameCheck::Verdict FrameCheck::judge(const double* change) const {
  Verdict verdict;
  if (pairs_.empty()) return verdict;
  verdict.dead = reading_zero(change);
  if (noise_.limit > 0) {
    if (along_reference_.size() <= stack_pairs) {
      Eigen::Matrix<double, Eigen::Dynamic, 1, 0, stack_pairs, 1> means(along_reference_.size());
      judge_pairs(change, means, verdict);
    } else {
      Eigen::VectorXd means(along_reference_.size());
      judge_pairs(change, means, verdict);
    }
  }
  verdict.dead = fewest(verdict.dead);
  if (verdict.has_gaps()) verdict.reasons |= dead_electrode;
  return verdict;
}

template <typename Vector>
void FrameCheck::judge_pairs(const double* change, Vector& means, Verdict& verdict) const {
  const double differences = split(change, means.data());
  const double signal = means.squaredNorm();
  if (!std::isfinite(differences + signal)) return;
  const double along = along_reference_.dot(means);
  const double frame = signal + reference_size_ * (2 * along + reference_size_);
  const double beside = noise_of_change_ ? signal : frame;
  const FrameCheck& flagging = flagging_ ? *flagging_ : *this;
  if (verdict.dead != 0 || noise_.relative(differences, beside) > noise_.limit) {
    const ElectrodeSet floats = floating(change, beside) | verdict.dead;
    if (floats != 0 && !noisy_without(change, floats, least_pairs)) {
      verdict.dead = floats;
    } else {
      if (verdict.dead == 0) find_loose(change, usual_noise(beside), verdict);
      const UsualLevel& level = flagging.noise_;
      const double signal_beside = flagging.noise_of_change_ ? signal : frame;
      const bool is_noisy = (verdict.dead | floats) == 0
                                ? level.relative(differences, signal_beside) > level.limit
                                : flagging.noisy_without(change, verdict.dead, 0);
      if (is_noisy && !(verdict.torn && verdict.dead == 0)) verdict.reasons |= noise;
    }
  }
  if (!verdict.has_gaps()) find_half_dead(means, verdict);
  if (verdict.has_gaps() || verdict.reasons != 0) return;
  if (flagging.out_of_range_of(means, signal)) verdict.reasons |= out_of_range;
}

template <typename Vector>
bool FrameCheck::out_of_range_of(Vector& means, double signal) const {
  const double size = signal + least_size_;
  const double over_size = 1 / std::sqrt(size);
  means = over_size * means - directions_.mean;
  const PrincipalDirections::Place place = directions_.place(means);
  return signal > largest_ || outside_.relative(place.outside * size, signal) > outside_.limit ||
         place.distance > farthest_ || place.along < lowest_ || place.along > highest_;
}

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

void FrameCheck::report(const Verdict& verdict, bool masked, FrameReport& report) {
  report.reasons |= verdict.reasons;
  report.dead = verdict.dead;
  int against = verdict.reasons;
  if (masked && size_of(verdict.dead) <= most_masked) against &= ~dead_electrode;
  // Dead channels, not the solver, are the reason why the iteration did not converge.
  const bool explains =
      (against & dead_electrode) != 0 && report.status == FrameStatus::not_converged;
  if ((against != 0 && report.status == FrameStatus::ok) || explains) {
    report.status = FrameStatus::suspect;
  }
}

FrameCheck::Shapes FrameCheck::shapes() const {
  Eigen::MatrixXd factors(along_reference_.size(), directions_.rows.rows() + 1);
  factors << directions_.mean,
      directions_.rows.transpose() *
          directions_.inverse_power.cwiseSqrt().cwiseInverse().asDiagonal();
  return {std::move(factors), least_size_, outside_.a, outside_.b};
}

std::pair<double, int> FrameCheck::differences(const double* change, ElectrodeSet dead) const {
  double squares = 0;
  int count = 0;
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const auto& [a, b] = pairs_[p];
    if (a == b || pair_electrodes_[p] & dead) continue;
    squares += square(change[a] - change[b]) / 2;
    ++count;
  }
  return {squares, count};
}

}  // namespace ertbench
