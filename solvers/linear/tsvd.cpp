#include "solvers/linear/tsvd.h"

#include <Spectra/SymEigsSolver.h>
#include <spdlog/spdlog.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "core/errors.h"
#include "solvers/solver_file.h"

namespace ertbench {
namespace {

constexpr double rank_tolerance = 1e-13;

/// The operator [0 D; D^T 0] with the deflated matrix D = C - left diag(values) right^T.
class DeflatedOperator {
 public:
  using Scalar = double;

  DeflatedOperator(const Eigen::MatrixXd& c, const SingularTriplets& found)
      : rest_(c - found.left * found.values.asDiagonal() * found.right.transpose()) {}
  Eigen::Index rows() const { return 2 * rest_.rows(); }
  Eigen::Index cols() const { return rows(); }
  void perform_op(const double* in, double* out) const {
    const Eigen::Index n = rest_.rows();
    Eigen::Map<Eigen::VectorXd>(out, n).noalias() =
        rest_ * Eigen::Map<const Eigen::VectorXd>(in + n, n);
    Eigen::Map<Eigen::VectorXd>(out + n, n).noalias() =
        rest_.transpose() * Eigen::Map<const Eigen::VectorXd>(in, n);
  }

 private:
  Eigen::MatrixXd rest_;
};

/// Orthogonalises `vector` to the columns of `basis`.
void orthogonalise(const Eigen::MatrixXd& basis, Eigen::VectorXd& vector) {
  for (int twice = 0; twice < 2; ++twice) vector -= basis * (basis.transpose() * vector);
}

/// Adds a triplet of c from its vectors, with the Rayleigh quotient as its value.
void append(SingularTriplets& found, const Eigen::MatrixXd& c, Eigen::VectorXd left,
            Eigen::VectorXd right) {
  orthogonalise(found.left, left);
  orthogonalise(found.right, right);
  left.normalize();
  right.normalize();
  const Eigen::Index k = found.values.size();
  found.values.conservativeResize(k + 1);
  found.left.conservativeResize(Eigen::NoChange, k + 1);
  found.right.conservativeResize(Eigen::NoChange, k + 1);
  found.values[k] = left.dot(c * right);
  found.left.col(k) = left;
  found.right.col(k) = right;
}

void sort_and_cut(SingularTriplets& found, Eigen::Index count) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(found.values.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index i, Eigen::Index j) {
    return found.values[i] > found.values[j];
  });
  order.resize(static_cast<std::size_t>(std::min(count, found.values.size())));
  found = SingularTriplets{found.values(order), found.left(Eigen::all, order),
                           found.right(Eigen::all, order)};
}

void check_residuals(const Eigen::MatrixXd& c, const SingularTriplets& found) {
  const auto s = found.values.asDiagonal();
  const double error =
      std::max((c * found.right - found.left * s).colwise().norm().maxCoeff(),
               (c.transpose() * found.left - found.right * s).colwise().norm().maxCoeff());
  if (!(error <= 1e-12 * found.values[0])) {
    throw std::runtime_error("the singular value decomposition did not converge");
  }
}

SingularTriplets triplets_of_square(const Eigen::MatrixXd& c, Eigen::Index count) {
  const Eigen::Index n = c.rows();
  SingularTriplets found{Eigen::VectorXd(0), Eigen::MatrixXd(n, 0), Eigen::MatrixXd(n, 0)};
  while (found.values.size() < n) {
    // First all wanted values; then a few at a time, to see whether a larger one was missed.
    const bool enough = found.values.size() >= count;
    const Eigen::Index wanted =
        std::min(2 * n - 1, enough ? 4 : std::max<Eigen::Index>(4, count - found.values.size()));
    const Eigen::Index space = std::min(2 * n, std::max<Eigen::Index>(2 * wanted + 1, 40));
    DeflatedOperator op(c, found);
    Spectra::SymEigsSolver<DeflatedOperator> solver(op, wanted, space);
    solver.init();
    solver.compute(Spectra::SortRule::LargestAlge, 1000, 1e-14);
    const Eigen::VectorXd values = solver.eigenvalues();
    const Eigen::MatrixXd vectors = solver.eigenvectors();

    double largest = found.values.size() ? found.values.maxCoeff() : 0;
    if (values.size()) largest = std::max(largest, values.maxCoeff());
    const double floor = enough ? found.values[count - 1] : rank_tolerance * largest;
    bool more = false;
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      if (values[i] <= floor * (1 + 1e-12) || values[i] <= rank_tolerance * largest) continue;
      append(found, c, vectors.col(i).head(n), vectors.col(i).tail(n));
      more = true;
    }
    sort_and_cut(found, n);
    if (!more) break;
  }
  sort_and_cut(found, count);
  return found;
}

/// Largest power of two not above a value; 1 for 0 and for values that are not finite.
double power_of_two_near(double value) {
  return value > 0 && std::isfinite(value) ? std::exp2(std::ilogb(value)) : 1.0;
}

/// Singular values closer than this, relative to the largest, form a pair: rounding separates them
/// by 1e-15, the sensor's geometry by far more.
bool same_value(const SingularTriplets& triplets, Eigen::Index i, Eigen::Index j) {
  const Eigen::VectorXd& s = triplets.values;
  return std::abs(s[i] - s[j]) <= 1e-9 * s[std::min(i, j)] + 1e-13 * s[0];
}

/// True if the rank keeps one value of a pair and drops the other.
bool splits_pair(const SingularTriplets& triplets, Eigen::Index rank) {
  return rank < triplets.values.size() && same_value(triplets, rank - 1, rank);
}

}  // namespace

SingularTriplets leading_singular_triplets(const Eigen::MatrixXd& a, Eigen::Index count) {
  if (a.rows() > a.cols()) {
    SingularTriplets found = leading_singular_triplets(a.transpose(), count);
    std::swap(found.left, found.right);
    return found;
  }
  const Eigen::Index n = a.rows();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a.transpose());
  Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  // The iteration treats numbers below about 1e-20 as zero. Scaling by a power of two is exact.
  const double scale = power_of_two_near(r.cwiseAbs().maxCoeff());
  r /= scale;
  SingularTriplets found = triplets_of_square(r.transpose(), std::min(count, n));
  check_residuals(r.transpose(), found);
  found.values *= scale;
  Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(a.cols(), found.right.cols());
  padded.topRows(n) = found.right;
  found.right = qr.householderQ() * padded;
  return found;
}

TruncatedSvd::TruncatedSvd(JsonObject parameters)
    : LinearSolver(LinearInference::from_json(parameters)) {
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
  choice_ = read_chosen(parameters, cut_.value);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json TruncatedSvd::parameters() const {
  nlohmann::json out = fit_parameters();
  inference().add_to(out);
  return out;
}

nlohmann::json TruncatedSvd::fit_parameters() const {
  const char* key = by_rank_ ? "rank" : "threshold";
  nlohmann::json out = {{key, "auto"}};
  if (cut_.value && by_rank_) out[key] = std::llround(*cut_.value);
  if (cut_.value && !by_rank_) out[key] = *cut_.value;
  mask().add_to(out);
  if (choice_) out["chosen"] = to_json(*choice_);
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
  const Eigen::MatrixXd jacobian = whole_jacobian()(kept_pairs(), Eigen::all);
  const Eigen::Index most = std::min(jacobian.rows(), jacobian.cols());

  // One more value shows whether the rank splits a pair.
  const auto triplets_to = [&](Eigen::Index rank) {
    return leading_singular_triplets(jacobian, std::min(rank + 1, most));
  };
  if (by_rank_ && cut_.value) {
    const auto rank = static_cast<Eigen::Index>(*cut_.value);
    const SingularTriplets triplets = triplets_to(rank);
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

  SingularTriplets triplets = triplets_to(most);
  if (cut_.automatic()) {
    set_rank(triplets, choose_rank(input, triplets));
    return;
  }
  const double least = *cut_.value * triplets.values[0];
  Eigen::Index rank = (triplets.values.array() >= least).count();
  while (splits_pair(triplets, rank)) ++rank;
  set_rank(triplets, rank);
}

void TruncatedSvd::set_rank(const SingularTriplets& triplets, Eigen::Index rank) {
  least_kept_ = triplets.values[rank - 1];
  set_inverse(triplets.right.leftCols(rank),
              triplets.values.head(rank).cwiseInverse().asDiagonal() *
                  triplets.left.leftCols(rank).transpose());
}

Eigen::Index TruncatedSvd::choose_rank(const FitInput& input, SingularTriplets& triplets) {
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
  choice_ = choice;
  return best;
}

void TruncatedSvd::save(const std::filesystem::path& file) const {
  Hdf5File out = create_solver_file(file, type, sensor(), fit_parameters());
  out.write_number("/", "least_singular_value", least_kept_);
  save_matrix(out);
  out.close();
}

void TruncatedSvd::load(const std::filesystem::path& file, const Sensor& sensor) {
  const Hdf5File opened = open_solver_file(file, type, sensor);
  const nlohmann::json parameters = parameters_of_fit(opened);
  read(JsonObject(parameters, file.string(), "/parameters"));
  if (opened.has_attribute("/", "least_singular_value")) {
    least_kept_ = opened.read_number("/", "least_singular_value");
  }
  load_matrix(opened, sensor);
}

}  // namespace ertbench
