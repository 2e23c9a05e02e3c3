#include "solvers/total_variation/registration.h"

#include "solvers/total_variation/pdipm.h"

namespace ertbench {

std::vector<SolverType> total_variation_solvers() {
  SolverInfo info;
  info.summary =
      "total variation by a primal-dual interior point method, min 1/2 |J x - dv|^2 + alpha |A "
      "x|_1";
  info.parameters = {
      {"alpha",
       "weight of the total variation, > 0 or \"auto\"; default \"auto\"; V^2 per (S/m "
       "x domain unit)"},
      {"tolerance", "relative duality gap at which a frame is done, 1e-8 ... 0.1; default 1e-4"},
      {"max_iterations",
       "Newton steps after which a frame is given up as not converged, 1 ... "
       "1000; default 50"},
      ChannelMask::parameter()};
  info.make = make_from_json<Pdipm>;
  info.comparison = ImageComparison::duality_gap;
  return {{Pdipm::type, info}};
}

}  // namespace ertbench
