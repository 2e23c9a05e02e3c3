#include "solvers/total_variation/interior_point.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ertbench {
namespace {

constexpr Eigen::Index gram_lanes = 8;
constexpr Eigen::Index rows_at_once = 64;  ///< of G, which stay in the first-level cache
using GramLanes = Eigen::Array<double, gram_lanes, 1>;

/// Eight columns of the sum from `sum`, `registers` times eight rows of it, in registers all the
/// while. `left` and `right` point into the first of `rows` rows of G.
template <int registers>
void add_tile(const double* left, const double* right, Eigen::Index stride, Eigen::Index rows,
              double* sum, Eigen::Index sum_stride) {
  std::array<std::array<GramLanes, registers>, gram_lanes> tile;
  for (std::size_t a = 0; a < gram_lanes; ++a) {
    for (std::size_t b = 0; b < registers; ++b) tile[a][b].setZero();
  }
  for (Eigen::Index k = 0; k < rows; ++k, left += stride, right += stride) {
    std::array<GramLanes, registers> row;
    for (std::size_t b = 0; b < registers; ++b) {
      row[b] = Eigen::Map<const GramLanes>(right + b * gram_lanes);
    }
    for (std::size_t a = 0; a < gram_lanes; ++a) {
      for (std::size_t b = 0; b < registers; ++b) tile[a][b] += left[a] * row[b];
    }
  }
  for (std::size_t a = 0; a < gram_lanes; ++a, sum += sum_stride) {
    for (std::size_t b = 0; b < registers; ++b) {
      Eigen::Map<GramLanes>(sum + b * gram_lanes) += tile[a][b];
    }
  }
}

constexpr int refinements = 4;    ///< at most
constexpr double refined = 1e-8;  ///< relative mismatch between J x and w that is small enough

constexpr double to_border = 0.99;  ///< of the way to the border of the positive cone
/// Least alpha-weighted edge weight, where |J| = 1: a proximal term that bounds rounding at large
/// edges and does not change the optimum.
constexpr double least_weight = 1e-14;
/// With a larger alpha every image is constant.
constexpr double greatest_alpha = 1e12;
/// Upper limit of the initial z+ and z-, which make mu account for the whole objective, in units of
/// the image that explains a unit of the leading channel.
constexpr double greatest_start = 10;
constexpr int iterations_with_useful_channels = 15;

}  // namespace

void add_gram(const RowMajorMatrix& tall, Eigen::Index rows, Eigen::MatrixXd& sum) {
  const Eigen::Index stride = tall.cols();
  for (Eigen::Index first = 0; first < rows; first += rows_at_once) {
    const Eigen::Index size = std::min(rows_at_once, rows - first);
    const double* const g = tall.data() + first * stride;
    for (Eigen::Index a = 0; a < sum.cols(); a += gram_lanes) {
      Eigen::Index b = a;
      const auto tile = [&](auto add, Eigen::Index width) {
        add(g + a, g + b, stride, size, &sum(b, a), sum.rows());
        b += width;
      };
      while (sum.rows() - b >= 3 * gram_lanes) tile(add_tile<3>, 3 * gram_lanes);
      if (sum.rows() - b == 2 * gram_lanes) tile(add_tile<2>, 2 * gram_lanes);
      if (sum.rows() - b == gram_lanes) tile(add_tile<1>, gram_lanes);
    }
  }
}

NewtonSystem::NewtonSystem(const TotalVariation& problem)
    : problem_(problem),
      band_(problem.edges().columns(), problem.edges().rows()),
      work_(problem.edges().pixels() - 1) {}

bool NewtonSystem::factor(const Eigen::VectorXd& weights, Eigen::Index channels) {
  band_.factor(problem_.edges(), weights);
  half_.resize(band_.unknowns(), channels);
  band_.half_solve(problem_.jacobian_transposed(), channels, half_);
  schur_.setIdentity(channels, channels);
  add_gram(half_, band_.unknowns(), schur_);
  schur_factor_.compute(schur_);
  if (schur_factor_.info() != Eigen::Success) return false;
  constant_ = problem_.constant().head(channels);
  constant_solve_ = schur_factor_.solve(constant_);
  constant_product_ = constant_.dot(constant_solve_);
  return true;
}

void NewtonSystem::solve(const Eigen::VectorXd& right, Eigen::VectorXd& x) {
  const Eigen::Index unknowns = band_.unknowns();
  const Eigen::Index channels = half_.cols();
  work_ = right.head(unknowns);
  band_.half_solve(work_);
  data_.noalias() = half_.transpose() * work_;
  double c = solve_data(data_, right.sum());
  work_.noalias() -= half_ * data_;
  band_.half_solve_transposed(work_);
  x.head(unknowns) = work_.array() + c;
  x[unknowns] = c;

  // If H is small beside J^T J, x is a small difference of large numbers and J x differs from w.
  double before = std::numeric_limits<double>::infinity();
  for (int refinement = 0; refinement < refinements; ++refinement) {
    error_.noalias() = problem_.jacobian_transposed().leftCols(channels).transpose() * x;
    error_ -= data_;
    const double error = error_.norm();
    if (!(error > refined * data_.norm() && error < before / 2)) break;
    before = error;
    c = solve_data(error_, 0);
    data_ += error_;
    work_.noalias() = -half_ * error_;
    band_.half_solve_transposed(work_);
    x.head(unknowns) += (work_.array() + c).matrix();
    x[unknowns] += c;
  }
}

/// Solves S w - c J 1 = data, (J 1)^T w = sum; w replaces the data, c is returned.
double NewtonSystem::solve_data(Eigen::VectorXd& data, double sum) const {
  schur_factor_.solveInPlace(data);
  const double c = (sum - constant_.dot(data)) / constant_product_;
  data += c * constant_solve_;
  return c;
}

InteriorPoint::InteriorPoint(const TotalVariation& problem)
    : problem_(problem), system_(problem), edges_(problem.edges().count()) {
  const Eigen::Index pixels = problem.edges().pixels();
  for (Eigen::VectorXd* v : {&x_, &gradient_, &dual_residual_, &best_x_, &right_, &pixel_}) {
    v->resize(pixels);
  }
  for (Eigen::VectorXd* v : {&y_, &edge_, &feasible_y_, &dual_step_}) v->resize(edges_);
  direction_.x.resize(pixels);
  corrected_.x.resize(pixels);
}

void InteriorPoint::minimise(const Eigen::Ref<const Eigen::RowVectorXd>& frame,
                             const InteriorPointOptions& options,
                             Eigen::Ref<Eigen::RowVectorXd> image, FrameReport& report) {
  image.setZero();
  data_ = problem_.project(frame);
  const double size = data_.stableNorm();
  if (!std::isfinite(size)) {
    report.status = FrameStatus::undefined;
    return;
  }
  if (size < 1e-300) return;
  data_ /= size;
  alpha_ =
      std::min(options.alpha * problem_.edge_length() / size / problem_.scale(), greatest_alpha);

  start();
  const Eigen::Index useful = useful_channels();
  while (gap_ > options.tolerance) {
    report.status = FrameStatus::not_converged;
    if (report.iterations == options.max_iterations) break;
    const bool trust = report.iterations < iterations_with_useful_channels;
    if (!step(trust ? useful : data_.size())) break;
    ++report.iterations;
    update_gap();
    if (gap_ <= options.tolerance) report.status = FrameStatus::ok;
  }
  report.gap = gap_;
  image = best_x_.transpose() * (size / problem_.scale());
  if (!image.allFinite()) {
    image.setZero();
    report.status = FrameStatus::undefined;
  }
}

/// Starts at the best constant image, with a dual variable well inside its bounds.
void InteriorPoint::start() {
  const Eigen::VectorXd& constant = problem_.constant();
  x_.setConstant(constant.dot(data_) / constant.squaredNorm());
  y_.setZero();
  objective_ = std::numeric_limits<double>::infinity();
  bound_ = 0;  // the bound of w = 0, y = 0
  update_gap();
  const double largest = feasible_y_.lpNorm<Eigen::Infinity>();
  y_ = feasible_y_ * std::min(1.0, 0.5 / largest);
  above_.setConstant(
      edges_, std::min(greatest_start, objective_ / (2 * static_cast<double>(edges_) * alpha_)));
  below_ = above_;
  dual_residual_ = gradient_;
  problem_.edges().transposed(y_, pixel_);
  dual_residual_ += alpha_ * pixel_;
}

/// Steps from the iterate to a dual feasible point and updates the gap there.
void InteriorPoint::update_gap() {
  const PixelEdges& edges = problem_.edges();
  const RowMajorMatrix& jt = problem_.jacobian_transposed();
  const Eigen::VectorXd& constant = problem_.constant();
  edges.differences(x_, edge_);
  residual_.noalias() = jt.transpose() * x_;
  residual_ -= data_;
  const double objective = residual_.squaredNorm() / 2 + alpha_ * edge_.lpNorm<1>();
  if (objective < objective_) {
    objective_ = objective;
    best_x_ = x_;
  }
  gradient_.noalias() = jt * residual_;
  edges.transposed(y_, pixel_);
  dual_residual_ = gradient_ + alpha_ * pixel_;

  const double part = constant.dot(residual_) / constant.squaredNorm();
  along_ = residual_ - part * constant;
  // A^T A z = -(J^T w) / alpha - A^T y, y + A z.
  right_ = (part * problem_.constant_gradient() - dual_residual_) / alpha_;
  problem_.laplacian().half_solve(right_);
  problem_.laplacian().half_solve_transposed(right_);
  right_[right_.size() - 1] = 0;
  edges.differences(right_, dual_step_);
  feasible_y_ = y_ + dual_step_;

  const double square = along_.squaredNorm();
  const double product = -along_.dot(data_);
  if (square > 0 && product > 0) {
    const double scale = std::min(product / square, 1 / feasible_y_.lpNorm<Eigen::Infinity>());
    bound_ = std::max(bound_, scale * (product - scale * square / 2));
  }
  gap_ = std::max(0.0, objective_ - bound_) / std::max(objective_, 0.5e-10);
}

Eigen::Index InteriorPoint::useful_channels() const {
  // The other channels have s^2 below alpha / 100, small beside the weight of any edge.
  const double least = 0.1 * std::sqrt(alpha_);
  const auto useful = (problem_.singular_values().array() >= least).count();
  return std::clamp<Eigen::Index>(GridLaplacian::padded(useful), GridLaplacian::block,
                                  data_.size());
}

/// The Newton direction to z+ (1 - y) = above_target, z- (1 + y) = below_target.
void InteriorPoint::solve(const Eigen::ArrayXd& above_target, const Eigen::ArrayXd& below_target,
                          Direction& direction) {
  shift_ = weight_ * (edge_.array() - above_target * above_slack_ + below_target * below_slack_);
  dual_step_ = shift_;
  problem_.edges().transposed(dual_step_, pixel_);
  right_ = -dual_residual_ - alpha_ * pixel_;
  system_.solve(right_, direction.x);
  problem_.edges().differences(direction.x, dual_step_);
  direction.y = weight_ * dual_step_.array() + shift_;
  direction.above = (above_target + above_ * direction.y) * above_slack_ - above_;
  direction.below = (below_target - below_ * direction.y) * below_slack_ - below_;
}

/// The step length at which the first of z+, z-, 1 - y, 1 + y becomes zero.
double InteriorPoint::longest(const Direction& direction) const {
  const double fastest =
      std::max({(direction.y * above_slack_).maxCoeff(), (-direction.y * below_slack_).maxCoeff(),
                (-direction.above / above_).maxCoeff(), (-direction.below / below_).maxCoeff()});
  return fastest > 0 ? 1 / fastest : std::numeric_limits<double>::infinity();
}

bool InteriorPoint::step(Eigen::Index channels) {
  above_slack_ = (1 - y_.array()).inverse();
  below_slack_ = (1 + y_.array()).inverse();
  weight_ = (above_ * above_slack_ + below_ * below_slack_).inverse();
  const double count = 2 * static_cast<double>(edges_);
  const double mu = ((above_ / above_slack_).sum() + (below_ / below_slack_).sum()) / count;
  if (!system_.factor((alpha_ * weight_).max(least_weight).matrix(), channels)) return false;

  // Predictor: towards mu = 0; the feasible step length determines the reduction of mu.
  above_target_.setZero(edges_);
  below_target_.setZero(edges_);
  solve(above_target_, below_target_, direction_);
  const double reach = std::min(1.0, longest(direction_));
  const double left =
      (((above_ + reach * direction_.above) * (1 - y_.array() - reach * direction_.y)).sum() +
       ((below_ + reach * direction_.below) * (1 + y_.array() + reach * direction_.y)).sum()) /
      count;
  const double target = std::pow(left / mu, 3) * mu;

  // Corrector: products of the predictor's steps, the error of its linearisation.
  above_target_ = target + direction_.above * direction_.y;
  below_target_ = target - direction_.below * direction_.y;
  solve(above_target_, below_target_, direction_);
  double length = longest(direction_);

  // Centrality: pulls back products that a longer step would make too small or too large.
  for (int i = 0; i < corrections && length < 1; ++i) {
    const double trial = std::min(1.0, 1.5 * length + 0.1);
    const auto drawn_back = [target](const auto& product) {
      return (product.max(0.1 * target).min(10 * target) - product).max(-10 * target);
    };
    above_trial_ = (above_ + trial * direction_.above) * (1 - y_.array() - trial * direction_.y);
    below_trial_ = (below_ + trial * direction_.below) * (1 + y_.array() + trial * direction_.y);
    above_trial_ = above_target_ + drawn_back(above_trial_);
    below_trial_ = below_target_ + drawn_back(below_trial_);
    solve(above_trial_, below_trial_, corrected_);
    const double longer = longest(corrected_);
    if (longer < 1.1 * length && !(longer > length && length > 0.9)) break;
    length = longer;
    std::swap(direction_, corrected_);
    std::swap(above_target_, above_trial_);
    std::swap(below_target_, below_trial_);
  }

  length = std::min(1.0, to_border * length);
  if (!direction_.x.allFinite() || !(length > 1e-10)) return false;
  x_ += length * direction_.x;
  y_.array() += length * direction_.y;
  above_ += length * direction_.above;
  below_ += length * direction_.below;
  return true;
}

}  // namespace ertbench
