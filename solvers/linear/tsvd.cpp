#include "solvers/linear/tsvd.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/hdf5_file.h"

namespace ertbench {
namespace {

constexpr double rank_tolerance = 1e-13;

/// Singular values closer than this, relative to the largest, form a pair: rounding separates them
/// by 1e-15, the sensor's geometry by far more.
bool same_value(const DenseSvd& triplets, Eigen::Index i, Eigen::Index j) {
  const Eigen::VectorXd& s = triplets.values;
  return std::abs(s[i] - s[j]) <= 1e-9 * s[std::min(i, j)] + 1e-13 * s[0];
}

/// True if the rank keeps one value of a pair and drops the other.
bool splits_pair(const DenseSvd& triplets, Eigen::Index rank) {
  return rank < triplets.values.size() && same_value(triplets, rank - 1, rank);
}

}  // namespace

DenseSvd singular_triplets(const Eigen::MatrixXd& a) {
  const DenseSvd all = dense_svd(a);
  const Eigen::Index rank = (all.values.array() > rank_tolerance * all.values[0]).count();
  return {all.left.leftCols(rank), all.values.head(rank), all.right.leftCols(rank)};
}

TruncatedSvd::TruncatedSvd(JsonObject parameters)
    : LinearSolver(type, LinearInference::from_json(parameters)) {
  read(std::move(parameters));
}

void TruncatedSvd::read(JsonObject parameters) {
  if (parameters.has("rank") && parameters.has("threshold")) {
    parameters.fail("", "give \"rank\" or \"threshold\", not both");
  }
  by_rank_ = !parameters.has("threshold");
  cut_ = by_rank_ ? read_tunable(parameters, "rank", Range::at_least(1), true)
                  : read_tunable(parameters, "threshold", Range{1e-15, 1});
  if (!by_rank_ && cut_.value == 1.0) {
    parameters.fail("threshold", "must be >= 1e-15 and < 1 or \"auto\", got 1");
  }
  read_chosen(parameters, cut_);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json TruncatedSvd::fit_parameters() const {
  const char* key = by_rank_ ? "rank" : "threshold";
  nlohmann::json out;
  cut_.add_to(out, key);
  if (cut_.value && by_rank_) out[key] = std::llround(*cut_.value);
  mask().add_to(out);
  return out;
}

void TruncatedSvd::check(const Sensor& sensor) const {
  mask().check(sensor);
  const auto pairs = static_cast<int>(pairs_without(sensor, mask().electrodes).size());
  const int most = std::min(pairs, sensor.pixels());
  if (by_rank_ && cut_.value && *cut_.value > most) {
    throw InputError(cut_.place + ": must be <= " + std::to_string(most) +
                     ", the rank of the Jacobian: its " + std::to_string(2 * pairs) +
                     " channels are " + std::to_string(pairs) +
                     " reciprocal pairs with equal rows, for " + std::to_string(sensor.pixels()) +
                     " pixels; got " + std::to_string(std::llround(*cut_.value)));
  }
}

void TruncatedSvd::fit(const FitInput& input) {
  truncate(input);
  finish();
}

std::unique_ptr<const FrameInverse> TruncatedSvd::frame_inverse() const {
  return std::make_unique<MaskedTsvd>(whole_jacobian(), least_kept_);
}

void TruncatedSvd::truncate(const FitInput& input) {
  set_sensor(input.sensor);
  const DenseSvd triplets = singular_triplets(whole_jacobian()(kept_pairs(), Eigen::all));
  if (by_rank_ && cut_.value) {
    const auto rank = static_cast<Eigen::Index>(*cut_.value);
    if (rank > triplets.values.size()) {
      throw InputError(cut_.place + ": must be <= " + std::to_string(triplets.values.size()) +
                       ", the numerical rank of this sensor's Jacobian; got " +
                       std::to_string(rank));
    }
    if (splits_pair(triplets, rank)) {
      spdlog::warn("{}: {} splits a pair of equal singular values; {} or {} would not", cut_.place,
                   rank, rank - 1, rank + 1);
    }
    set_rank(triplets, rank);
    return;
  }
  if (cut_.automatic()) {
    set_rank(triplets, choose_rank(input, triplets));
    return;
  }
  const double least = *cut_.value * triplets.values[0];
  Eigen::Index rank = (triplets.values.array() >= least).count();
  while (splits_pair(triplets, rank)) ++rank;
  set_rank(triplets, rank);
}

void TruncatedSvd::set_rank(const DenseSvd& triplets, Eigen::Index rank) {
  least_kept_ = triplets.values[rank - 1];
  set_inverse(triplets.right.leftCols(rank),
              triplets.values.head(rank).cwiseInverse().asDiagonal() *
                  triplets.left.leftCols(rank).transpose());
}

Eigen::Index TruncatedSvd::choose_rank(const FitInput& input, const DenseSvd& triplets) {
  const ValidationFrames frames = read_validation_frames(input, cut_.place);
  ParameterChoice choice;
  choice.frames = static_cast<int>(frames.changes.rows());
  choice.error = std::numeric_limits<double>::infinity();
  Eigen::Index best = 1;
  for (Eigen::Index rank = 1; rank <= triplets.values.size(); ++rank) {
    if (splits_pair(triplets, rank)) continue;
    set_rank(triplets, rank);
    const double error = mean_relative_error(*this, frames, input.threads);
    // The threshold lies half way (in the logarithm) to the next value, or below the last one.
    const Eigen::VectorXd& s = triplets.values;
    const double next = rank < s.size() ? s[rank] : s[rank - 1] / 4;
    const double cut = by_rank_ ? static_cast<double>(rank) : std::sqrt(s[rank - 1] * next) / s[0];
    choice.curve.emplace_back(cut, error);
    if (error < choice.error) {
      choice.error = error;
      choice.value = cut;
      best = rank;
    }
  }
  if (best == triplets.values.size()) {
    spdlog::warn("{}: \"auto\" found its best rank {} at the end of the range", cut_.place, best);
  }
  std::sort(choice.curve.begin(), choice.curve.end());
  cut_.value = choice.value;
  cut_.choice = choice;
  return best;
}

void TruncatedSvd::save_fit(Hdf5File& file) const {
  file.write_number("/", "least_singular_value", least_kept_);
  save_matrix(file);
}

void TruncatedSvd::load_fit(const Hdf5File& file, const Sensor& sensor) {
  cut_.require_chosen();
  if (file.has_attribute("/", "least_singular_value")) {
    least_kept_ = file.read_number("/", "least_singular_value");
  }
  load_matrix(file, sensor);
}

}  // namespace ertbench
