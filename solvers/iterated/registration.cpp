#include "solvers/iterated/registration.h"

#include "solvers/iterated/gauss_newton.h"

namespace ertbench {

std::vector<SolverType> iterated_solvers() {
  SolverInfo info;
  info.summary =
      "iterated Gauss-Newton on the grid model, min 1/2 |F(t) - dv|^2 + penalty, bounded "
      "conductivity";
  info.parameters = {
      {"prior",
       "the penalty: \"tikhonov\", \"noser\", \"laplace\" as one-step-gn has them, "
       "\"total-variation\" (smoothed at .01 of the background), \"training\" (Gaussian, of the "
       "training images' covariance); default \"noser\""},
      {"lambda",
       "weight of the penalty, > 0 or \"auto\"; default \"auto\"; its unit depends on the prior: V "
       "per S/m for tikhonov and laplace, V^2 per (S/m x domain unit) for total-variation, V for "
       "training"},
      {"bounds",
       "[low, high] of the conductivity beside the background, 0 <= low < 1 < high; default [0, "
       "2]"},
      {"tolerance",
       "relative change of the image at which a frame is done, 1e-10 ... 0.5; default 1e-2"},
      {"max_iterations",
       "after which a frame is given up as not converged, 1 ... 1000; default 20"},
      {"discrepancy",
       "done as soon as the misfit is this many times the frame's noise, as reciprocal channels "
       "show it; default 0: it does not end an iteration"},
      {"calibrate",
       "multiply each channel with the ratio of the grid model's reference voltage to the "
       "validation set's, which undoes a part of the grid's error; default false"},
      ChannelMask::parameter()};
  info.make = make_from_json<GaussNewton>;
  return {{GaussNewton::type, info}};
}

}  // namespace ertbench
