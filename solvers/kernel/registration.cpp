#include "solvers/kernel/registration.h"

#include "solvers/kernel/kernel_ridge.h"

namespace ertbench {

std::vector<SolverType> kernel_solvers() {
  SolverInfo info;
  info.summary =
      "kernel ridge regression from voltages to the place and the strength of one contact, its "
      "scales by leave-one-out";
  info.parameters = {
      {"input",
       "what frames are compared by: \"direction\" of their change, its norm apart (the default), "
       "or the \"raw\" change"},
      {"width",
       "of the radial basis, over the median squared distance of the training frames, 1e-6 ... "
       "1e6, or \"auto\" (the default)"},
      {"lambda", "the ridge, 1e-12 ... 1e6 or \"auto\" (the default)"},
      {"norm_weight",
       "of the logarithm of the norm beside the direction, 0 ... 1e6 or \"auto\" (the default)"},
      {"strength",
       "the same three of the regression to the contact's strength, {\"width\", \"lambda\", "
       "\"norm_weight\"}; default \"auto\""},
      {"validation",
       "\"joined\" (the default): the validation set is learned from as well, for nothing is "
       "chosen on it; or \"left-out\""},
      {"most_frames", "learned from, 3 ... 20000; default 1000"}};
  info.make = make_from_json<KernelRidge>;
  return {{KernelRidge::type, info}};
}

}  // namespace ertbench
