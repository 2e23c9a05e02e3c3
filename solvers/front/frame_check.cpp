#include "solvers/front/frame_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/errors.h"
#include "core/statistics.h"
#include "forward/data/dataset_file.h"
#include "forward/data/sheet_model.h"
#include "solvers/decompositions.h"

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
/// Ratio of fits at which noise counts as following the change rather than the frame.
constexpr double much_closer = 0.8;
constexpr Eigen::Index stack_pairs = 256;

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
    least_bad_.push_back(static_cast<int>(std::ceil(bad_share * static_cast<double>(used))));
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
