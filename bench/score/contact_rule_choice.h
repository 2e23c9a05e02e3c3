#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>

#include "bench/score/image_contacts.h"

namespace ertbench {

class DatasetFile;
class Solver;

/// Thresholds tried for "auto".
inline constexpr std::array thresholds_to_try = {0.15, 0.2,  0.25, 0.3, 0.35,
                                                 0.4,  0.45, 0.5,  0.6, 0.7};
/// Floors tried for "auto", as shares of the 90 % quantile of the largest |δσ| of the validation
/// images, so that the scale of images does not matter.
inline constexpr std::array floors_to_try = {0.0,  0.01, 0.02, 0.04, 0.07, 0.1,
                                             0.15, 0.2,  0.3,  0.4,  0.5};
/// Number of frames used, from the first of the set (validation or ContactSettings::chosen_on) on.
inline constexpr int frames_of_choice = 500;

/// The rule that detects contacts in a solver's images.
struct ContactRuleChoice {
  ContactRule rule;
  int frames = 0;  ///< frames it was chosen on; 0 if nothing was chosen
};

/// Chooses threshold and floor, unless the settings give them, by the same procedure for every
/// solver: the pair with the least mean OSPA distance over the validation frames that have an
/// image. Among equals the default of ContactRule wins, then the first. Without a validation set
/// (`validation` is null) or an image the defaults are used.
ContactRuleChoice choose_contact_rule(const ContactSettings& settings, const Sensor& sensor,
                                      const Solver& solver, const DatasetFile* validation);

/// `{"threshold", "floor", "saddle", "chosen_on": frames}`, for the parameters of a row.
nlohmann::json to_json(const ContactRuleChoice& choice);

}  // namespace ertbench
