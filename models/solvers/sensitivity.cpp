#include "models/solvers/sensitivity.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "core/json_reader.h"
#include "forward/data/uniform_sheet.h"
#include "solvers/linear/one_step_gn.h"

namespace ertbench {
namespace {

constexpr double cut_share = 0.25;

/// Images [frames, pixels] of `changes` [frames, channels] by one-step Gauss-Newton.
Images gauss_newton(const FitInput& input, const nlohmann::json& parameters,
                    const Frames& changes) {
  OneStepGaussNewton solver(JsonObject(parameters, "one-step-gn", ""));
  solver.fit(input);
  Images images(changes.rows(), input.sensor.pixels());
  std::vector<FrameReport> reports(static_cast<std::size_t>(changes.rows()));
  solver.reconstruct(changes, images, reports);
  return images;
}

}  // namespace

RowMajorMatrix sensitivity_inverse(const FitInput& input) {
  const int channels = input.sensor.channels();
  return gauss_newton(input, {{"prior", "noser"}}, Frames::Identity(channels, channels))
      .transpose();
}

void set_sensitivity_inverse(torch::nn::Linear& layer, const FitInput& input,
                             const Standardisation& standardisation) {
  // y = -G (v - v0) / (c0 image), and v0 - v = mean + x / scale.
  const Eigen::MatrixXf inverse =
      (sensitivity_inverse(input) / (input.sensor.background * standardisation.image))
          .cast<float>();
  const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> weight =
      inverse * standardisation.scale.cwiseInverse().asDiagonal();
  const Eigen::VectorXf bias = inverse * standardisation.mean.transpose();
  const torch::NoGradGuard no_gradients;
  layer->weight.copy_(
      torch::from_blob(const_cast<float*>(weight.data()), {weight.rows(), weight.cols()}));
  layer->bias.copy_(torch::from_blob(const_cast<float*>(bias.data()), {bias.size()}));
}

RowMajorMatrix spatial_blur(const FitInput& input, std::optional<double> lambda) {
  nlohmann::json parameters = {{"prior", "laplace"}};
  if (lambda) parameters["lambda"] = *lambda;
  const RowMajorMatrix jacobian = uniform_jacobian(input.sensor);
  RowMajorMatrix blur = gauss_newton(input, parameters, jacobian.transpose()).transpose();
  for (Eigen::Index column = 0; column < blur.cols(); ++column) {
    const double least = cut_share * blur.col(column).maxCoeff();
    blur.col(column) = (blur.col(column).array() < least).select(0.0, blur.col(column));
  }
  return blur;
}

}  // namespace ertbench
