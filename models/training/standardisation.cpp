#include "models/training/standardisation.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "forward/data/dataset_file.h"

namespace ertbench {
namespace {

constexpr std::uint64_t frames_considered = 20000;
constexpr std::uint64_t frames_at_a_time = 1024;

/// Standardisation::image of the first `count` scenes.
double image_unit(const DatasetFile& training, std::uint64_t count) {
  constexpr double rise_at = 0.9;
  double sum = 0;
  double least = 0;
  for (std::uint64_t first = 0; first < count; first += frames_at_a_time) {
    const Images y =
        1 - training.conductivity(first, std::min(frames_at_a_time, count - first)).array() /
                training.sensor().background;
    sum += y.sum();
    least = std::min(least, y.minCoeff());
  }
  return sum < 0 ? least / rise_at : 1;
}

}  // namespace

Standardisation Standardisation::of(const DatasetFile& training) {
  const std::uint64_t count = std::min(training.size(), frames_considered);
  const Eigen::RowVectorXd reference = training.reference_voltages().transpose();
  Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(reference.size());
  Eigen::RowVectorXd squares = sum;
  for (std::uint64_t first = 0; first < count; first += frames_at_a_time) {
    const Frames drops = -(
        training.voltages(first, std::min(frames_at_a_time, count - first)).rowwise() - reference);
    sum += drops.colwise().sum();
    squares += drops.colwise().squaredNorm();
  }
  const Eigen::RowVectorXd mean = sum / static_cast<double>(count);
  const Eigen::ArrayXXd variance =
      (squares / static_cast<double>(count) - mean.cwiseAbs2()).array().max(0);
  // A constant channel (empty scenes without noise) is not scaled.
  const Eigen::ArrayXXd scale =
      (variance > 1e-24 * reference.array().square()).select(variance.rsqrt(), 1.0);
  return {mean.cast<float>(), scale.matrix().cast<float>(), image_unit(training, count)};
}

torch::Tensor Standardisation::apply(const FramesView& changes) const {
  torch::Tensor out = torch::empty({changes.rows(), changes.cols()});
  float* row = out.data_ptr<float>();
  for (Eigen::Index f = 0; f < changes.rows(); ++f, row += changes.cols()) {
    apply(changes.row(f), row);
  }
  return out;
}

namespace {

constexpr double ridge = 1e-6;  ///< of the mean variance of the inputs

}  // namespace

LinearEstimate::LinearEstimate(Eigen::Index inputs, Eigen::Index outputs)
    : input_sum_(Eigen::VectorXd::Zero(inputs)),
      output_sum_(Eigen::VectorXd::Zero(outputs)),
      input_products_(Eigen::MatrixXd::Zero(inputs, inputs)),
      cross_products_(Eigen::MatrixXd::Zero(outputs, inputs)) {}

void LinearEstimate::add(const RowMajorMatrix& inputs, const RowMajorMatrix& outputs) {
  count_ += static_cast<double>(inputs.rows());
  input_sum_ += inputs.colwise().sum().transpose();
  output_sum_ += outputs.colwise().sum().transpose();
  input_products_.noalias() += inputs.transpose() * inputs;
  cross_products_.noalias() += outputs.transpose() * inputs;
}

LinearEstimate::Affine LinearEstimate::solve() const {
  const Eigen::VectorXd input_mean = input_sum_ / count_;
  const Eigen::VectorXd output_mean = output_sum_ / count_;
  Eigen::MatrixXd covariance = input_products_ / count_ - input_mean * input_mean.transpose();
  const Eigen::MatrixXd cross = cross_products_ / count_ - output_mean * input_mean.transpose();
  covariance.diagonal().array() += ridge * covariance.diagonal().mean();
  Affine out;
  out.weights = covariance.ldlt().solve(cross.transpose()).transpose();
  out.offset = output_mean - out.weights * input_mean;
  return out;
}

}  // namespace ertbench
