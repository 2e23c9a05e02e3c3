#include "solvers/linear/one_step_gn.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "solvers/linear/mmse.h"
#include "solvers/linear/tsvd.h"

namespace ertbench {
namespace {

/// (J^T J + lambda^2 R^T R)^-1 J^T for one lambda by a Cholesky factor, three times as fast.
/// Nothing where the square of lambda would be lost, for matrices so small that it does not matter,
/// and for priors with a free constant.
std::optional<Eigen::MatrixXd> direct_inverse(const Eigen::MatrixXd& jacobian,
                                              const PriorFactors& prior, double lambda) {
  constexpr Eigen::Index small = 512;
  constexpr double lost = 1e-9;
  if (prior.free_constant || jacobian.rows() <= small) return std::nullopt;
  const Eigen::VectorXd shaping = prior.shaping.diagonal();
  Eigen::MatrixXd shaped = jacobian * shaping.asDiagonal();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(shaped.rows(), shaped.rows());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(shaped);
  if (lambda * lambda < lost * gram.trace()) return std::nullopt;
  gram.diagonal().array() += lambda * lambda;
  gram.selfadjointView<Eigen::Lower>().llt().solveInPlace(shaped);
  return shaping.asDiagonal() * shaped.transpose();
}

/// `own` and the parameters that all linear solvers share.
std::vector<ParameterInfo> with_shared(std::vector<ParameterInfo> own) {
  own.push_back(ChannelMask::parameter());
  for (ParameterInfo& parameter : LinearInference::registered()) {
    own.push_back(std::move(parameter));
  }
  return own;
}

SolverInfo one_step_gauss_newton() {
  SolverInfo info;
  info.summary = "one-step Gauss-Newton, (J'J + lambda^2 R'R)^-1 J' dv (A4)";
  info.parameters =
      with_shared({{"prior",
                    "R'R: \"tikhonov\" (identity), \"noser\" (diag(J'J)^1/2), \"laplace\" (2 x the "
                    "pixel graph's Laplacian); default \"noser\""},
                   {"lambda",
                    "weight of the prior, > 0 or \"auto\"; default \"auto\"; its unit depends on "
                    "the prior, V per S/m for tikhonov and laplace"}});
  info.make = make_from_json<OneStepGaussNewton>;
  info.probes = {R"({"prior": "noser"})", R"({"prior": "tikhonov"})", R"({"prior": "laplace"})"};
  info.break_even_reference = true;
  return info;
}

SolverInfo truncated_svd() {
  SolverInfo info;
  info.summary = "truncated singular value decomposition of J";
  info.parameters =
      with_shared({{"rank", "singular values kept, 1 ... channels / 2 or \"auto\" (the default)"},
                   {"threshold",
                    "in place of a rank: values down to this part of the largest are kept, "
                    "between 0 and 1 or \"auto\""}});
  info.make = make_from_json<TruncatedSvd>;
  info.probes = {"{}", R"({"threshold": "auto"})"};
  return info;
}

/// One component is a matrix; a mixture is a class of its own.
std::unique_ptr<Solver> make_mmse(JsonObject parameters) {
  constexpr int most = 1024;
  if (parameters.integer_or("components", 1, 1, most) == 1) {
    return std::make_unique<LinearMmse>(std::move(parameters));
  }
  return std::make_unique<MixtureMmse>(std::move(parameters));
}

SolverInfo linear_mmse() {
  SolverInfo info;
  info.summary =
      "linear minimum mean square error, E[x d'] (E[d d'] + ridge)^-1 dv from the training scenes, "
      "or the posterior mean under a mixture of several";
  info.parameters = with_shared(
      {{"components",
        "Gaussians of which the scenes are a mixture, 1 (the default: one matrix) ... 1024; with "
        "several, the inference_ parameters do not apply: images are made in float32"},
       {"ridge",
        "noise beyond that of the training set, relative to the mean square of the changes, > 0 or "
        "\"auto\" (the default)"},
       {"symmetries", "learn from the scenes turned by the sensor's symmetries, too; default true"},
       {"inference_noise",
        "of one component: \"fit\" (the default), noise as in the training set, or \"frame\", as "
        "the reciprocal channels of each frame show it",
        ParameterRole::inference},
       Nuisances::parameter()});
  info.make = make_mmse;
  // With symmetries, directions come in pairs, in which rounding turns those of a mixture.
  info.probes = {"{}", R"({"components": 2, "symmetries": false})"};
  return info;
}

}  // namespace

OneStepGaussNewton::OneStepGaussNewton(JsonObject parameters)
    : LinearSolver(type, LinearInference::from_json(parameters)) {
  read(std::move(parameters));
}

void OneStepGaussNewton::read(JsonObject parameters) {
  prior_ = prior_from_name(
      parameters.choice_or("prior", name_of(Prior::noser), {"tikhonov", "noser", "laplace"}));
  lambda_ = read_weight(parameters, "lambda");
  read_chosen(parameters, lambda_);
  set_mask(ChannelMask::from_json(parameters));
  parameters.finish();
}

nlohmann::json OneStepGaussNewton::fit_parameters() const {
  nlohmann::json out = {{"prior", name_of(prior_)}};
  lambda_.add_to(out, "lambda");
  mask().add_to(out);
  return out;
}

void OneStepGaussNewton::fit(const FitInput& input) {
  set_sensor(input.sensor);
  const Eigen::MatrixXd jacobian = whole_jacobian();
  const PriorFactors prior = prior_factors(prior_, jacobian, sensor().image_columns());
  const Eigen::MatrixXd kept = jacobian(kept_pairs(), Eigen::all);
  if (const auto direct =
          lambda_.automatic() ? std::nullopt : direct_inverse(kept, prior, *lambda_.value)) {
    set_inverse(*direct);
    finish();
    return;
  }
  SpectralInverse inverse(kept, prior);
  const auto set_lambda = [&](double lambda) {
    inverse.set_noise(lambda * lambda);
    set_inverse(inverse.matrix());
  };
  if (lambda_.automatic()) {
    const ValidationFrames frames = read_validation_frames(input, lambda_.place);
    const double largest = std::sqrt(inverse.largest_power());
    lambda_.choose(*this, frames, input.threads, {1e-4 * largest, largest}, 4, set_lambda);
  }
  set_lambda(*lambda_.value);
  finish();
}

std::unique_ptr<const FrameInverse> OneStepGaussNewton::frame_inverse() const {
  const Eigen::MatrixXd jacobian = whole_jacobian();
  auto out = std::make_unique<SpectralInverse>(
      jacobian, prior_factors(prior_, jacobian, sensor().image_columns()));
  out->set_noise(*lambda_.value * *lambda_.value);
  return out;
}

void OneStepGaussNewton::load_fit(const Hdf5File& file, const Sensor& sensor) {
  lambda_.require_chosen();
  load_matrix(file, sensor);
}

std::vector<SolverType> linear_solvers() {
  return {{OneStepGaussNewton::type, one_step_gauss_newton()},
          {TruncatedSvd::type, truncated_svd()},
          {LinearMmse::type, linear_mmse()}};
}

}  // namespace ertbench
