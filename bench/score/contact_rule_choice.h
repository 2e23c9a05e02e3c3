#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>

#include "bench/score/image_contacts.h"

namespace ertbench {

class DatasetFile;
class Solver;

/// The thresholds that are tried where it is "auto".
inline constexpr std::array thresholds_to_try = {0.15, 0.2,  0.25, 0.3, 0.35,
                                                 0.4,  0.45, 0.5,  0.6, 0.7};
/// The floors, as parts of the 90 % quantile of the largest |δσ| of the validation images, so that
/// an image's scale means nothing.
inline constexpr std::array floors_to_try = {0.0,  0.01, 0.02, 0.04, 0.07, 0.1,
                                             0.15, 0.2,  0.3,  0.4,  0.5};
/// Frames of the set (the validation set or ContactSettings::chosen_on) that are looked at, the
/// first ones.
inline constexpr int frames_of_choice = 500;

/// The rule by which contacts are read out of a solver's images.
struct ContactRuleChoice {
  ContactRule rule;
  int frames = 0;  ///< of the set that it was chosen on; 0 where nothing was chosen
};

/// Chooses what the settings leave open, by the same procedure for every solver: the pair of
/// threshold and floor with the least mean OSPA distance over the validation frames that have an
/// image; of equally good ones the default of ContactRule, else the first. Without a validation set
/// (`validation` is null), or where no frame has an image, the defaults stand.
ContactRuleChoice choose_contact_rule(const ContactSettings& settings, const Sensor& sensor,
                                      const Solver& solver, const DatasetFile* validation);

/// `{"threshold", "floor", "saddle", "chosen_on": frames}`, as the parameters of a row have it.
nlohmann::json to_json(const ContactRuleChoice& choice);

}  // namespace ertbench
