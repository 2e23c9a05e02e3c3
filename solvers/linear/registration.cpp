#include "solvers/linear/registration.h"

#include "solvers/linear/linear_mmse.h"
#include "solvers/linear/mixture_mmse.h"
#include "solvers/linear/one_step_gn.h"
#include "solvers/linear/tsvd.h"

namespace ertbench {
namespace {

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
  return info;
}

/// The mixture is applied otherwise than one matrix, and is a class of its own.
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
       {"symmetries",
        "learn from the scenes turned by the sensor's symmetries, too; default true"}});
  info.make = make_mmse;
  return info;
}

}  // namespace

std::vector<SolverType> linear_solvers() {
  return {{OneStepGaussNewton::type, one_step_gauss_newton()},
          {TruncatedSvd::type, truncated_svd()},
          {LinearMmse::type, linear_mmse()}};
}

}  // namespace ertbench
