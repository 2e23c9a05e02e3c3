#include "solvers/linear/registration.h"

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

}  // namespace

std::vector<SolverType> linear_solvers() {
  return {{OneStepGaussNewton::type, one_step_gauss_newton()},
          {TruncatedSvd::type, truncated_svd()}};
}

}  // namespace ertbench
