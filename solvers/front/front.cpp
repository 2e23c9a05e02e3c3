#include "solvers/front/front.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "forward/data/sheet_model.h"
#include "solvers/channel_mask.h"
#include "solvers/decompositions.h"

namespace ertbench {
namespace {

/// Contacts are no Gaussians: what their directions leave is this often as large beside a nuisance
/// as pair by pair. With it amplitudes scatter on sound frames as their deviations say.
constexpr double heavy = 10;

}  // namespace

Front::Front(const Sensor& sensor, const Nuisances& nuisances)
    : Front(sensor, FrameCheck(sensor, 0), nuisances) {}

Front::Front(const Sensor& sensor, FrameCheck check, const Nuisances& nuisances)
    : check_(std::move(check)),
      electrodes_(sensor.electrode_count),
      reference_(uniform_reference(sensor)),
      reference_size_(std::sqrt(reference_.square().mean())) {
  if (check_.has_limits()) set_model(sensor, nuisances);
}

void Front::set_model(const Sensor& sensor, const Nuisances& nuisances) {
  shapes_ = check_.shapes();
  const Eigen::Index pairs = shapes_.factors.rows();
  const SymmetricEigen eigen = symmetric_eigen(shapes_.factors.transpose() * shapes_.factors);
  const auto kept = (eigen.values.array() > 1e-9 * eigen.values.maxCoeff()).count();
  moments_ = eigen.values.tail(kept);
  const Eigen::MatrixXd basis = shapes_.factors * eigen.vectors.rightCols(kept) *
                                moments_.cwiseSqrt().cwiseInverse().asDiagonal();

  std::vector<double> deviations;
  if (nuisances.factor() > 0) deviations.push_back(nuisances.factor());
  if (nuisances.gradient > 0) deviations.insert(deviations.end(), 2, nuisances.gradient);
  const auto even = static_cast<Eigen::Index>(deviations.size());
  if (nuisances.electrodes > 0) {
    deviations.insert(deviations.end(), static_cast<std::size_t>(electrodes_),
                      nuisances.electrodes);
  }
  deviations_ = Eigen::Map<const Eigen::VectorXd>(deviations.data(), std::ssize(deviations));
  nuisances_ = deviations_.size();
  // A rise of the conductivity lowers the voltages.
  Eigen::MatrixXd columns = nuisances.responses(sensor) * deviations_.cwiseInverse().asDiagonal();
  if (nuisances.factor() > 0) columns.col(0) *= -1;
  responses_ = columns.leftCols(even);
  rows_.resize(kept + nuisances_, pairs);
  rows_.topRows(kept) = basis.transpose();
  for (Eigen::Index c = 0; c < nuisances_; ++c) {
    check_.means(columns.col(c).data(), rows_.row(kept + c).data());
  }
  const auto bottom = rows_.bottomRows(nuisances_);
  within_ = (bottom * basis).transpose();
  beside_ = bottom * bottom.transpose() - within_.transpose() * within_;
}

double Front::noise(const double* change, ElectrodeSet dead) const {
  const auto [squares, count] = check_.differences(change, dead);
  return count > 0 ? std::sqrt(squares / count) : 0;
}

bool Front::saturated(const double* change) const {
  const Eigen::ArrayXd frame =
      (Eigen::Map<const Eigen::ArrayXd>(change, reference_.size()) + reference_).abs();
  const double end = frame.maxCoeff();
  // Three channels that differ at the reference are equal, and larger than any there.
  const auto at_end = frame >= (1 - 1e-9) * end;
  return end > 1.15 * reference_.abs().maxCoeff() && at_end.count() >= 3;
}

FrameState Front::look(const double* change) const {
  FrameState state;
  const FrameCheck::Verdict verdict = check_.judge(change);
  state.dead = verdict.dead;
  state.lost = verdict.lost_share;
  if (verdict.lost_share > 0) state.half_dead = verdict.dead;
  state.floating = state.dead & ~state.half_dead & ~check_.reading_zero(change);
  state.saturated = saturated(change);
  state.noise = noise(change, state.dead);
  if (!check_.has_limits()) return state;
  thread_local Eigen::VectorXd imputed;
  if (verdict.has_gaps()) {
    imputed = Eigen::Map<const Eigen::VectorXd>(change, reference_.size());
    check_.impute(imputed.data(), verdict);
    change = imputed.data();
  }
  thread_local Eigen::VectorXd means;
  thread_local Eigen::VectorXd products;
  means.resize(rows_.cols());
  check_.means(change, means.data());
  products.noalias() = rows_ * means;
  const double square = means.squaredNorm();
  const auto pairs = static_cast<double>(means.size());
  const Scores scores = products.head(moments_.size());
  const Scores power = (square + shapes_.least_size) * moments_;
  const double outside = std::max(0.0, square - scores.squaredNorm());
  const bool has_noise = check_.differences(change, state.dead).second > 0;
  if (!has_noise) {
    state.noise = std::sqrt(outside / std::max(1.0, pairs - static_cast<double>(scores.size())));
  }
  const double rho =
      (std::max(shapes_.residual, has_noise ? pairs * state.noise * state.noise : 0) +
       shapes_.residual_of_square * square) /
      pairs;

  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most, most>;
  const double wide = heavy * rho;
  const Scores weights = (power.array() + wide).inverse();
  Square normal = beside_ / wide;
  normal.noalias() += within_.transpose() * weights.asDiagonal() * within_;
  normal.diagonal() += deviations_.cwiseAbs2().cwiseInverse();
  const FrameState::Amplitudes outside_along =
      products.segment(scores.size(), nuisances_) - within_.transpose() * scores;
  FrameState::Amplitudes right = outside_along / wide;
  right.noalias() += within_.transpose() * weights.cwiseProduct(scores);
  const Eigen::LLT<Square> factored(normal);
  const FrameState::Amplitudes amplitudes = factored.solve(right);
  state.amplitudes = amplitudes;
  // The diagonal of the inverse of L L^T.
  const Square inverse = factored.matrixL().solve(Square::Identity(nuisances_, nuisances_));
  state.deviations = inverse.colwise().norm().transpose();
  const double left = outside + amplitudes.dot(beside_ * amplitudes - 2 * outside_along);
  state.unexplained = std::max(0.0, left) / (rho * pairs);
  return state;
}

void Front::remove_nuisances(const FrameState& state, double* change) const {
  if (responses_.cols() == 0 || state.amplitudes.size() == 0) return;
  Eigen::Map<Eigen::VectorXd>(change, reference_.size()) -=
      responses_ * state.amplitudes.head(responses_.cols());
}

void Front::tell(const double* change, ElectrodeSet dead, float* told) const {
  constexpr double middle_db = 50;
  constexpr double unit_db = 15;
  for (int e = 0; e < electrodes_; ++e) *told++ = static_cast<float>(dead >> e & 1);
  const double noise_of_frame = noise(change, dead);
  // A frame without noise is told as 95 dB, one without a reciprocal pair too.
  const double snr = noise_of_frame > 0 ? 20 * std::log10(reference_size_ / noise_of_frame) : 95;
  *told = static_cast<float>(std::clamp((snr - middle_db) / unit_db, -3.0, 3.0));
}

void Front::prepare(double* change, float* told) const {
  const FrameCheck::Verdict verdict = check_.judge(change);
  if (verdict.has_gaps()) check_.impute(change, verdict);
  tell(change, verdict.lost(), told);
}

}  // namespace ertbench
