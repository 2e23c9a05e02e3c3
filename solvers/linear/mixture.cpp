#include "solvers/linear/mixture.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/errors.h"
#include "core/random.h"
#include "forward/data/dataset_file.h"
#include "solvers/decompositions.h"
#include "solvers/linear/linear_solver.h"

namespace ertbench {
namespace {

constexpr std::uint64_t read_at_once = 1000;
constexpr Eigen::Index scenes_at_once = 512;  ///< scenes of one matrix product

/// Pair that a symmetry maps to each pair; both channels of a pair come from one other pair.
std::vector<Eigen::Index> turned_pairs(const Reciprocity& reciprocity, const Symmetry& symmetry) {
  std::vector<Eigen::Index> pair_of(symmetry.channels.size());
  for (Eigen::Index p = 0; p < reciprocity.pairs(); ++p) {
    for (const int channel : reciprocity.pair(p)) pair_of[static_cast<std::size_t>(channel)] = p;
  }
  std::vector<Eigen::Index> from;
  for (Eigen::Index p = 0; p < reciprocity.pairs(); ++p) {
    const auto channel = static_cast<std::size_t>(reciprocity.pair(p)[0]);
    from.push_back(pair_of[static_cast<std::size_t>(symmetry.channels[channel])]);
  }
  return from;
}

constexpr int rounds = 12;
constexpr Eigen::Index points_at_once = 1024;  ///< points of one matrix product

/// k-means++ (Arthur, Vassilvitskii 2007): centres are points, drawn with probability proportional
/// to their squared distance to the centres drawn before.
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

/// Nearest centre of each point.
std::vector<Eigen::Index> nearest_centres(const Eigen::MatrixXf& points,
                                          const Eigen::MatrixXf& centres) {
  // |p - c|^2 without |p|^2, which does not depend on the centre.
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

/// Directions of the changes from which images are estimated, and by which components are
/// distinguished. On one to three contacts at 50 dB, 64 and 24 have the least error among 40, 64,
/// 104 and 16, 24, 32, 48, 104; the rest is noise that few scenes do not determine.
constexpr Eigen::Index image_directions = 64;
constexpr Eigen::Index gate_directions = 24;
/// Weight of the pooled covariance, in scenes, when it is mixed with a component's own.
constexpr double shared_scenes = 50;
constexpr double noise_part = 0.2;  ///< of the directions, the weakest, hold the noise alone

/// Up to `count` eigenvectors of a symmetric matrix, in descending order of their values.
Eigen::MatrixXd leading(const SymmetricEigen& eigen, Eigen::Index count) {
  const Eigen::Index size = std::min(count, eigen.vectors.cols());
  return eigen.vectors.rightCols(size).rowwise().reverse();
}

/// Features for k-means [scenes, directions + 1]: the shape of the change and the logarithm of its
/// size, to which ten standard deviations of the noise are added.
Eigen::MatrixXf features(const TrainingScenes& scenes, const Eigen::MatrixXd& directions,
                         double noise) {
  constexpr double weight_of_shape = 1.5;
  Eigen::MatrixXf out(scenes.count(), directions.cols() + 1);
  Eigen::RowVectorXd change(scenes.pairs());
  for (Eigen::Index i = 0; i < scenes.count(); ++i) {
    scenes.change(i, change);
    const double size = change.norm() + 10 * noise;
    out.row(i).head(directions.cols()) =
        (weight_of_shape / size * (change * directions)).cast<float>();
    out(i, directions.cols()) = static_cast<float>(std::log(size / noise));
  }
  return out;
}

}  // namespace

TrainingScenes::TrainingScenes(const FitInput& input, const std::string& place, bool symmetries) {
  if (!input.training) {
    throw InputError(place + ": needs a training set; add \"train\" to the datasets");
  }
  const DatasetFile& set = *input.training;
  if (set.sensor() != input.sensor) {
    throw InputError(place + ": the training set " + set.path().string() +
                     " is of another sensor; generate it for this one");
  }
  const Reciprocity reciprocity(input.sensor);
  changes_.resize(static_cast<Eigen::Index>(set.size()), reciprocity.pairs());
  images_.resize(static_cast<Eigen::Index>(set.size()), input.sensor.pixels());
  for (std::uint64_t first = 0; first < set.size(); first += read_at_once) {
    const std::uint64_t count = std::min(read_at_once, set.size() - first);
    const auto row = static_cast<Eigen::Index>(first);
    const Frames voltages = set.voltages(first, count);
    images_.middleRows(row, static_cast<Eigen::Index>(count)) =
        (set.conductivity(first, count).array() - input.sensor.background).cast<float>();
    for (Eigen::Index f = 0; f < voltages.rows(); ++f) {
      changes_.row(row + f) =
          reciprocity.reduce(voltages.row(f) - set.reference_voltages().transpose()).transpose();
    }
  }
  // Rounding of the conductivities in the file does not count as a contact.
  const auto rounding = static_cast<float>(1e-6 * input.sensor.background);
  if (images_.size() == 0 || images_.cwiseAbs().maxCoeff() <= rounding) {
    throw InputError(place + ": needs a training set with contacts; " + set.path().string() +
                     " has none");
  }
  for (const Symmetry& symmetry : ertbench::symmetries(input.sensor)) {
    turns_.push_back(
        {turned_pairs(reciprocity, symmetry), {symmetry.pixels.begin(), symmetry.pixels.end()}});
    if (!symmetries) break;
  }
}

void TrainingScenes::change(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const {
  const Turn& turn = turns_[static_cast<std::size_t>(index / changes_.rows())];
  const double* const row = changes_.row(index % changes_.rows()).data();
  for (Eigen::Index p = 0; p < out.size(); ++p)
    out[p] = row[turn.pairs[static_cast<std::size_t>(p)]];
}

void TrainingScenes::image(Eigen::Index index, Eigen::Ref<Eigen::RowVectorXd> out) const {
  const Turn& turn = turns_[static_cast<std::size_t>(index / images_.rows())];
  const float* const row = images_.row(index % images_.rows()).data();
  for (Eigen::Index p = 0; p < out.size(); ++p) {
    out[p] = static_cast<double>(row[turn.pixels[static_cast<std::size_t>(p)]]);
  }
}

JointMoments moments_of(const TrainingScenes& scenes, const std::vector<Eigen::Index>& which,
                        bool about_zero) {
  const Eigen::Index count =
      which.empty() ? scenes.count() : static_cast<Eigen::Index>(which.size());
  JointMoments out{static_cast<double>(count), Eigen::VectorXd::Zero(scenes.pairs()),
                   Eigen::VectorXd::Zero(scenes.pixels()),
                   Eigen::MatrixXd::Zero(scenes.pairs(), scenes.pairs()),
                   Eigen::MatrixXd::Zero(scenes.pixels(), scenes.pairs())};
  RowMajorMatrix changes(scenes_at_once, scenes.pairs());
  RowMajorMatrix images(scenes_at_once, scenes.pixels());
  for (Eigen::Index first = 0; first < count; first += scenes_at_once) {
    const Eigen::Index size = std::min(scenes_at_once, count - first);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index index =
          which.empty() ? first + i : which[static_cast<std::size_t>(first + i)];
      scenes.change(index, changes.row(i));
      scenes.image(index, images.row(i));
    }
    const auto d = changes.topRows(size);
    const auto x = images.topRows(size);
    out.changes.noalias() += d.transpose() * d;
    out.cross.noalias() += x.transpose() * d;
    out.change_mean += d.colwise().sum().transpose();
    out.image_mean += x.colwise().sum().transpose();
  }
  out.changes /= out.scenes;
  out.cross /= out.scenes;
  out.change_mean /= out.scenes;
  out.image_mean /= out.scenes;
  if (about_zero) {
    out.change_mean.setZero();
    out.image_mean.setZero();
  } else {
    out.changes -= out.change_mean * out.change_mean.transpose();
    out.cross -= out.image_mean * out.change_mean.transpose();
  }
  return out;
}

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

Eigen::MatrixXd GaussianMixture::second_moment() const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(directions.rows(), directions.rows());
  for (const Component& c : components) {
    out += c.weight * (c.changes + c.change_mean * c.change_mean.transpose());
  }
  return out;
}

GaussianMixture fit_mixture(const TrainingScenes& scenes, int components) {
  const SymmetricEigen eigen = symmetric_eigen(moments_of(scenes, {}, true).changes);
  const auto weakest =
      static_cast<Eigen::Index>(std::ceil(noise_part * static_cast<double>(eigen.values.size())));
  const double largest = std::sqrt(eigen.values[eigen.values.size() - 1]);
  const double noise =
      std::max(std::sqrt(std::max(eigen.values.head(weakest).mean(), 0.0)), 1e-9 * largest);

  GaussianMixture out;
  out.directions = leading(eigen, image_directions);
  const std::vector<std::vector<Eigen::Index>> groups =
      k_means(features(scenes, leading(eigen, gate_directions), noise), components);
  Eigen::MatrixXd changes_within = Eigen::MatrixXd::Zero(scenes.pairs(), scenes.pairs());
  Eigen::MatrixXd cross_within = Eigen::MatrixXd::Zero(scenes.pixels(), out.directions.cols());
  for (const std::vector<Eigen::Index>& group : groups) {
    JointMoments moments = moments_of(scenes, group, false);
    const double weight = moments.scenes / static_cast<double>(scenes.count());
    out.components.push_back({weight, std::move(moments.change_mean), std::move(moments.image_mean),
                              std::move(moments.changes), moments.cross * out.directions});
    changes_within += weight * out.components.back().changes;
    cross_within += weight * out.components.back().cross;
  }
  for (GaussianMixture::Component& c : out.components) {
    const double own = c.weight * static_cast<double>(scenes.count());
    const double shared = shared_scenes / (own + shared_scenes);
    c.changes += shared * (changes_within - c.changes);
    c.cross += shared * (cross_within - c.cross);
  }
  return out;
}

MixtureMean::MixtureMean(const GaussianMixture& mixture, const std::vector<Eigen::Index>& kept,
                         double ridge) {
  const Eigen::MatrixXd whole = mixture.second_moment();
  const double noise = ridge * whole.diagonal().mean();
  // Equal to `directions` if all pairs are kept.
  const Eigen::MatrixXd directions =
      leading(symmetric_eigen(whole(kept, kept)), mixture.directions.cols());
  // Transforms the covariance of x with directions of all pairs to directions of the kept pairs.
  const Eigen::MatrixXd overlap = mixture.directions(kept, Eigen::all).transpose() * directions;
  const Eigen::Index size = directions.cols();
  const Eigen::Index gate = std::min(gate_directions, size);
  const auto count = static_cast<Eigen::Index>(mixture.components.size());

  coordinates_ = Matrix::Zero(size, whole.rows());
  coordinates_(Eigen::all, kept) = (directions.transpose() / std::numbers::sqrt2).cast<float>();
  whitening_.resize(count * gate, gate);
  centres_.resize(count * gate);
  log_weight_.resize(count);
  estimates_.reserve(mixture.components.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const GaussianMixture::Component& c = mixture.components[static_cast<std::size_t>(k)];
    const Eigen::VectorXd mean = directions.transpose() * c.change_mean(kept);
    Eigen::MatrixXd covariance = directions.transpose() * c.changes(kept, kept) * directions;
    covariance.diagonal().array() += noise;
    const Eigen::LLT<Eigen::MatrixXd> all(covariance);
    const Eigen::MatrixXd solved = all.solve((c.cross * overlap).transpose());
    estimates_.push_back({solved.transpose().cast<float>(),
                          (c.image_mean - solved.transpose() * mean).cast<float>()});
    // The leading block of the inverse factor belongs to the leading coordinates.
    const Eigen::MatrixXd inverse = all.matrixL().solve(Eigen::MatrixXd::Identity(size, size));
    whitening_.middleRows(k * gate, gate) = inverse.topLeftCorner(gate, gate).cast<float>();
    centres_.segment(k * gate, gate) =
        (inverse.topLeftCorner(gate, gate) * mean.head(gate)).cast<float>();
    log_weight_[k] = std::log(c.weight) + inverse.diagonal().head(gate).array().log().sum();
  }
}

void MixtureMean::estimate(const Eigen::Ref<const Eigen::VectorXd>& sums,
                           Eigen::Ref<Eigen::RowVectorXd> image) const {
  constexpr Eigen::Index most_pairs = 256;
  using Small = Eigen::Matrix<float, Eigen::Dynamic, 1, 0, most_pairs, 1>;
  thread_local Eigen::VectorXf whitened;
  thread_local Eigen::VectorXd score;
  thread_local Eigen::VectorXf out;
  thread_local Eigen::VectorXf in;

  in = sums.cast<float>();
  Small y(coordinates_.rows());
  y.noalias() = coordinates_ * in;
  const Eigen::Index gate = whitening_.cols();
  whitened.resize(whitening_.rows());
  whitened.noalias() = whitening_ * y.head(gate);
  whitened -= centres_;
  score.resize(log_weight_.size());
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    score[k] =
        log_weight_[k] - 0.5 * static_cast<double>(whitened.segment(k * gate, gate).squaredNorm());
  }
  score = (score.array() - score.maxCoeff()).exp();
  const double sum = (score.array() >= least_mixture_share).select(score.array(), 0).sum();
  out = Eigen::VectorXf::Zero(image.size());
  for (Eigen::Index k = 0; k < score.size(); ++k) {
    if (score[k] < least_mixture_share) continue;
    const Estimate& estimate = estimates_[static_cast<std::size_t>(k)];
    const auto share = static_cast<float>(score[k] / sum);
    out += share * estimate.constant;
    y *= share;
    out.noalias() += estimate.matrix * y;
    y /= share;
  }
  image = out.transpose().cast<double>();
}

void MixtureMean::add_layers(LayerList& list, const Reciprocity& reciprocity) const {
  // Half of the whitening's size, a power of two, goes to the coordinates: both fit half precision.
  const float scale = std::exp2(std::round(std::log2(whitening_.cwiseAbs().maxCoeff()) / 2));
  add_dense(list, scale * on_means(coordinates_.cast<double>(), reciprocity).cast<float>(),
            Eigen::VectorXf::Zero(coordinates_.rows()));
  const int coordinates = list.layers.back().value;
  std::vector<int> leading(static_cast<std::size_t>(whitening_.cols()));
  std::iota(leading.begin(), leading.end(), 0);
  list.layers.push_back({.kind = Layer::Kind::gather,
                         .inputs = {coordinates},
                         .value = coordinates + 1,
                         .width = static_cast<int>(leading.size()),
                         .indices = std::move(leading)});
  add_dense(list, whitening_ / scale, -centres_);
  Layer mean{.kind = Layer::Kind::mixture,
             .inputs = {coordinates + 2, coordinates},
             .value = coordinates + 3,
             .width = static_cast<int>(estimates_.front().matrix.rows())};
  for (std::size_t k = 0; k < estimates_.size(); ++k) {
    const FloatRows matrix = estimates_[k].matrix / scale;
    mean.weights.insert(mean.weights.end(), matrix.data(), matrix.data() + matrix.size());
    mean.bias.push_back(static_cast<float>(log_weight_[static_cast<Eigen::Index>(k)]));
    const Eigen::VectorXf& constant = estimates_[k].constant;
    mean.bias.insert(mean.bias.end(), constant.begin(), constant.end());
  }
  list.layers.push_back(std::move(mean));
}

}  // namespace ertbench
