#include "solvers/contacts/registration.h"

#include "solvers/contacts/contact_solver.h"

namespace ertbench {

std::vector<SolverType> contact_solvers() {
  SolverInfo info;
  info.summary =
      "contacts as unknowns: ellipses or discs, as many as the evidence asks for, fitted to the "
      "exact model of the sheet";
  info.parameters = {
      {"shape", "\"ellipse\" (the default) or \"disc\""},
      {"most_contacts", "in a frame, 1 ... 8; default 4"},
      {"model_error",
       "what contacts that are no ellipses leave, root mean square over that of the frame's "
       "change; counts as noise, 0 ... 0.5; default 0.02"},
      {"prior",
       "of a contact's size, stretch and ratio: \"broad\" (the default) or \"training\", that of "
       "the contacts in the training set"},
      {"prior_weight",
       "multiplies the prior's inverse variances, > 0 or \"auto\"; default \"auto\""},
      {"noise",
       "standard deviation of a channel, V, or \"auto\" (the default): from what the reciprocal "
       "channels of the validation set differ by"},
      {"conductivity_ratio",
       "[low, high] of every contact's conductivity over the background's, both below 1 or both "
       "above, where that is known; default none"},
      {"image",
       "\"mean\" (the default) of the posterior, or \"most-likely\": the contacts of its maximum"},
      {"nuisances",
       "unknowns beside the contacts, by their standard deviations: {\"gain\": relative, "
       "\"level\": of the whole sheet's conductivity, relative, \"gradient\": relative per domain "
       "unit, \"electrodes\": domain units}; default none"},
      ChannelMask::parameter()};
  info.make = make_from_json<ContactSolver>;
  // A step that is taken or not is decided by last bits.
  info.comparison = ImageComparison::rounding;
  return {{ContactSolver::type, info}};
}

}  // namespace ertbench
