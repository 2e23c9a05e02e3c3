#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "bench/contacts/contact_rule.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// How far apart contacts may be, mm.
struct ContactDistances {
  double match = 20;  ///< of a found contact from a true one that it is
  double ospa = 50;   ///< cut-off of the OSPA distance
};

/// "contacts" of an experiment: how contacts are read out of images and held against the true ones.
struct ContactSettings {
  std::optional<double> threshold;  ///< of ContactRule; nothing: chosen on the validation set
  std::optional<double> floor;      ///< the same
  /// The test set on which they are chosen in place of the validation set: one that no result is
  /// told of, and whose contacts and noise are like those of the others.
  std::string chosen_on;
  double saddle = ContactRule{}.saddle;
  std::optional<double> match_mm;  ///< nothing: a tenth of the sheet's longest side
  std::optional<double> ospa_mm;   ///< nothing: a quarter of it

  /// The rule where nothing is chosen: what is not given is ContactRule's default.
  ContactRule rule() const;
  ContactDistances distances(const Sensor& sensor) const;

  bool operator==(const ContactSettings&) const = default;
};

/// `{"threshold", "floor", "saddle", "match_mm", "ospa_mm", "chosen_on"}`; "auto" where nothing is
/// given.
nlohmann::json to_json(const ContactSettings& settings);

}  // namespace ertbench
