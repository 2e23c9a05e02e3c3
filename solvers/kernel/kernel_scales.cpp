#include "solvers/kernel/kernel_scales.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

namespace ertbench {
namespace {

/// What is tried for a scale.
std::vector<double> values_of(const Tunable& tunable, std::vector<double> tried) {
  return tunable.value ? std::vector{*tunable.value} : std::move(tried);
}

}  // namespace

KernelScaleChoice KernelScaleChoice::from_json(JsonObject& object) {
  return {read_tunable(object, "width", {1e-6, 1e6}), read_tunable(object, "lambda", {1e-12, 1e6}),
          read_tunable(object, "norm_weight", {0, 1e6})};
}

ChosenScales choose_scales(const KernelScaleChoice& choice, KernelInput input,
                           const RowMajorMatrix& changes, const Eigen::MatrixXd& targets) {
  const std::vector<double> widths =
      values_of(choice.width, {0.125, 0.25, 0.5, 1, 2, 4, 8, 16, 32});
  const std::vector<double> lambdas =
      values_of(choice.lambda, {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1});
  // Raw changes have their norms in them.
  const std::vector<double> weights = input == KernelInput::raw
                                          ? std::vector<double>{0}
                                          : values_of(choice.norm_weight, {0, 0.1, 0.2, 0.5, 1});
  ChosenScales best;
  best.error = std::numeric_limits<double>::infinity();
  for (const double weight : weights) {
    const RowMajorMatrix features = kernel_features(changes, input, weight);
    const Eigen::MatrixXd squared = squared_distances(features, features);
    const double median = median_distance(squared);
    for (const double width : widths) {
      const Eigen::MatrixXd kernel = (-squared.array() / (width * median)).exp();
      const std::vector<Eigen::MatrixXd> residuals = leave_one_out(kernel, targets, lambdas);
      for (std::size_t l = 0; l < lambdas.size(); ++l) {
        const double error = residuals[l].rowwise().norm().mean();
        if (error < best.error) best = {{width, lambdas[l], weight}, error};
      }
    }
  }
  return best;
}

nlohmann::json to_json(const KernelScales& scales) {
  return {{"width", scales.width}, {"lambda", scales.lambda}, {"norm_weight", scales.norm_weight}};
}

}  // namespace ertbench
