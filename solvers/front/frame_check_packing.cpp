// Packing of a FrameCheck into one vector of numbers, what it does to a frame as data, and
// imputation.

#include <Eigen/Cholesky>
#include <algorithm>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "core/arrays.h"
#include "forward/data/sheet_model.h"
#include "solvers/front/frame_check.h"

namespace ertbench {
namespace {

/// Takes vectors off the front of another.
class Unpacking {
 public:
  explicit Unpacking(const Eigen::VectorXd& all) : all_(all) {}

  Eigen::VectorXd take(Eigen::Index count) {
    if (count < 0 || count > all_.size() - done_) {
      throw std::invalid_argument("the frame check is damaged");
    }
    done_ += count;
    return all_.segment(done_ - count, count);
  }
  double take() { return take(1)[0]; }
  Eigen::Index left() const { return all_.size() - done_; }

 private:
  const Eigen::VectorXd& all_;
  Eigen::Index done_ = 0;
};

}  // namespace

Eigen::VectorXd FrameCheck::packed() const {
  std::vector<double> out(reference_.begin(), reference_.end());
  if (noise_.limit > 0) {
    out.insert(out.end(), {noise_.a, noise_.b, noise_.limit, outside_.a, outside_.b, outside_.limit,
                           noise_of_change_ ? 1.0 : 0.0, least_size_, largest_, farthest_, lowest_,
                           highest_, static_cast<double>(directions_.rows.rows())});
    const auto add = [&](const auto& values) {
      out.insert(out.end(), values.data(), values.data() + values.size());
    };
    add(directions_.mean);
    add(directions_.rows);
    add(directions_.inverse_power);
    add(directions_.tilt);
    if (flagging_) add(flagging_->packed());
  }
  return Eigen::Map<const Eigen::VectorXd>(out.data(), static_cast<Eigen::Index>(out.size()));
}

FrameCheck::FrameCheck(const Sensor& sensor, ElectrodeSet masked, const Eigen::VectorXd& packed) {
  set_sensor(sensor, masked);
  Unpacking in(packed);
  set_reference(in.take(sensor.channels()));
  if (packed.size() == sensor.channels()) return;
  for (UsualLevel* level : {&noise_, &outside_}) {
    level->a = in.take();
    level->b = in.take();
    level->limit = in.take();
  }
  noise_of_change_ = in.take() != 0;
  for (double* limit : {&least_size_, &largest_, &farthest_, &lowest_, &highest_}) {
    *limit = in.take();
  }
  const auto count = static_cast<Eigen::Index>(
      std::clamp(in.take(), 0.0, static_cast<double>(PrincipalDirections::most)));
  const auto pairs = static_cast<Eigen::Index>(pairs_.size());
  directions_.mean = in.take(pairs);
  const Eigen::VectorXd rows = in.take(count * pairs);
  directions_.rows = Eigen::Map<const Eigen::MatrixXd>(rows.data(), count, pairs);
  directions_.inverse_power = in.take(count);
  directions_.tilt = in.take(count);
  if (in.left() == 0) return;
  flagging_ = std::make_shared<const FrameCheck>(sensor, masked, in.take(in.left()));
  if (flagging_->flagging_) in.take(1);  // throws
}

FrameFront FrameCheck::front(const Sensor& sensor) const {
  FrameFront out{.electrodes = electrode_count_,
                 .neighbours = drives_neighbours_ ? 1 : 0,
                 .of_change = noise_of_change_ ? 1 : 0,
                 .pairs = {},
                 .users = pair_electrodes_,
                 .least_bad = least_bad_,
                 .reference = {reference_.begin(), reference_.end()},
                 .reference_square = uniform_reference(sensor).array().square().mean(),
                 .noise = noise_.a,
                 .noise_slope = noise_.b,
                 .limit = noise_.limit,
                 .least_size = least_size_,
                 .residual = outside_.a,
                 .residual_slope = outside_.b,
                 .directions = {}};
  for (const auto& pair : pairs_) out.pairs.insert(out.pairs.end(), pair.begin(), pair.end());
  const RowMajorMatrix factors = shapes().factors;
  out.directions.assign(factors.data(), factors.data() + factors.size());
  return out;
}

bool FrameCheck::condition(Eigen::Ref<Eigen::VectorXd> means, const std::vector<bool>& lost) const {
  std::vector<Eigen::Index> live;
  for (std::size_t p = 0; p < lost.size(); ++p) {
    if (!lost[p]) live.push_back(static_cast<Eigen::Index>(p));
  }
  if (!has_limits() || live.size() < static_cast<std::size_t>(least_pairs)) return false;
  const Eigen::MatrixXd moments = shapes().factors;
  const Eigen::MatrixXd known = moments(live, Eigen::all);
  const Eigen::VectorXd seen = means(live);
  const double signal =
      seen.squaredNorm() * static_cast<double>(means.size()) / static_cast<double>(seen.size());
  const double residual = (outside_.a + outside_.b * signal) / (signal + least_size_);
  Eigen::MatrixXd normal = known.transpose() * known;
  normal.diagonal().array() += residual / static_cast<double>(means.size());
  const Eigen::VectorXd along = normal.llt().solve(known.transpose() * seen);
  for (Eigen::Index p = 0; p < means.size(); ++p) {
    if (lost[static_cast<std::size_t>(p)]) means[p] = moments.row(p).dot(along);
  }
  return true;
}

void FrameCheck::impute_pairs(double* change, const std::vector<bool>& lost) const {
  Eigen::VectorXd means(along_reference_.size());
  split(change, means.data());
  if (!condition(means, lost)) return;
  for (std::size_t p = 0; p < lost.size(); ++p) {
    const auto& [a, b] = pairs_[p];
    if (lost[p]) change[a] = change[b] = means[static_cast<Eigen::Index>(p)] / std::numbers::sqrt2;
  }
}

void FrameCheck::impute(double* change, ElectrodeSet dead) const {
  std::vector<bool> lost(pairs_.size());
  for (std::size_t p = 0; p < lost.size(); ++p) lost[p] = (pair_electrodes_[p] & dead) != 0;
  impute_pairs(change, lost);
}

void FrameCheck::impute(double* change, const Verdict& verdict) const {
  if (!verdict.torn) return impute(change, verdict.dead);
  std::vector<int> reading;
  for (Eigen::Index c = 0; c < reference_.size(); ++c) {
    const bool zero = std::abs(change[c] + reference_[c]) <= nearly_zero_[c];
    if (!zero) reading.push_back(static_cast<int>(c));
  }
  impute(change, reading);
}

void FrameCheck::impute(double* change, const std::vector<int>& kept) const {
  std::vector<bool> known(static_cast<std::size_t>(reference_.size()), false);
  for (const int channel : kept) known[static_cast<std::size_t>(channel)] = true;
  std::vector<bool> lost(pairs_.size());
  for (std::size_t p = 0; p < lost.size(); ++p) {
    const auto& [a, b] = pairs_[p];
    const bool knows_a = known[static_cast<std::size_t>(a)];
    const bool knows_b = known[static_cast<std::size_t>(b)];
    if (knows_a && !knows_b) change[b] = change[a];
    if (knows_b && !knows_a) change[a] = change[b];
    lost[p] = !knows_a && !knows_b;
  }
  impute_pairs(change, lost);
}

}  // namespace ertbench
