#include "solvers/linear/k_means.h"

#include <algorithm>
#include <limits>

#include "core/random.h"

namespace ertbench {
namespace {

constexpr int rounds = 12;
constexpr Eigen::Index points_at_once = 1024;  ///< points of one matrix product

/// k-means++ (Arthur, Vassilvitskii 2007): each centre a point, drawn by its squared distance to
/// those drawn before.
Eigen::MatrixXf first_centres(const Eigen::MatrixXf& points, Eigen::Index count) {
  RandomStream random(1, key_of("k-means"), 0, Purpose::training);
  Eigen::MatrixXf centres(count, points.cols());
  Eigen::ArrayXf nearest =
      Eigen::ArrayXf::Constant(points.rows(), std::numeric_limits<float>::infinity());
  Eigen::Index drawn = random.integer(0, static_cast<int>(points.rows() - 1));
  for (Eigen::Index k = 0; k < count; ++k) {
    centres.row(k) = points.row(drawn);
    nearest = nearest.min((points.rowwise() - centres.row(k)).rowwise().squaredNorm().array());
    double left = random.uniform() * nearest.cast<double>().sum();
    for (drawn = 0; drawn < points.rows() - 1; ++drawn) {
      left -= static_cast<double>(nearest[drawn]);
      if (left < 0) break;
    }
  }
  return centres;
}

/// The nearest centre of each point.
std::vector<Eigen::Index> nearest_centres(const Eigen::MatrixXf& points,
                                          const Eigen::MatrixXf& centres) {
  // |p - c|^2 less |p|^2, which is the same for all centres.
  const Eigen::RowVectorXf squares = centres.rowwise().squaredNorm().transpose();
  std::vector<Eigen::Index> out(static_cast<std::size_t>(points.rows()));
  Eigen::MatrixXf distances;
  for (Eigen::Index first = 0; first < points.rows(); first += points_at_once) {
    const Eigen::Index size = std::min(points_at_once, points.rows() - first);
    distances.noalias() = -2.0F * points.middleRows(first, size) * centres.transpose();
    distances.rowwise() += squares;
    for (Eigen::Index i = 0; i < size; ++i) {
      distances.row(i).minCoeff(&out[static_cast<std::size_t>(first + i)]);
    }
  }
  return out;
}

}  // namespace

std::vector<std::vector<Eigen::Index>> k_means(const Eigen::MatrixXf& points, int groups) {
  Eigen::MatrixXf centres = first_centres(points, std::min<Eigen::Index>(groups, points.rows()));
  for (int round = 0;; ++round) {
    const std::vector<Eigen::Index> nearest = nearest_centres(points, centres);
    std::vector<std::vector<Eigen::Index>> out(static_cast<std::size_t>(centres.rows()));
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      out[static_cast<std::size_t>(nearest[i])].push_back(static_cast<Eigen::Index>(i));
    }
    if (round == rounds) {
      std::erase_if(out, [](const auto& group) { return group.empty(); });
      return out;
    }
    for (std::size_t k = 0; k < out.size(); ++k) {
      if (out[k].empty()) continue;
      centres.row(static_cast<Eigen::Index>(k)) = points(out[k], Eigen::all).colwise().mean();
    }
  }
}

}  // namespace ertbench
