#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/arrays.h"
#include "core/json.h"
#include "solvers/solver.h"

namespace ertbench {

/// The chosen value and the candidates.
struct ParameterChoice {
  double value = 0;
  double error = 0;                              ///< mean relative error at `value`
  int frames = 0;                                ///< that the mean is taken over
  std::vector<std::pair<double, double>> curve;  ///< (value, error) tried, values ascending
};

/// The frames that a choice is made on.
struct ValidationFrames {
  Frames changes;  ///< [frames, channels] V, change from the reference voltages
  Images truths;   ///< [frames, pixels] S/m, change from the background
};

/// A parameter that is a number, or "auto": chosen on the validation set.
struct Tunable {
  std::optional<double> value;  ///< none: "auto"
  std::string place;            ///< where it stands, for messages: "a.json: /solvers/2/lambda"
  std::optional<ParameterChoice> choice = {};  ///< by which the value came about, if it did

  bool automatic() const { return !value.has_value(); }
  /// Throws InputError where a stored fit has "auto".
  void require_chosen() const;
  /// Writes the value as `key`, and the choice as "chosen".
  void add_to(nlohmann::json& parameters, const std::string& key) const;
  /// Takes the value by choose_number whose images have the least mean relative error: those that
  /// `solver` makes of the frames after `set(value)`.
  void choose(const Solver& solver, const ValidationFrames& frames, int threads,
              std::pair<double, double> range, int per_decade,
              const std::function<void(double)>& set);
};

/// Reads `key`, "auto" where it is absent. Throws InputError unless it is "auto" or a number in
/// `range` (and whole where `whole`).
Tunable read_tunable(JsonObject& object, std::string_view key, Range range, bool whole = false);

/// Chooses, likewise, the weight of a prior, a number > 0 whose square and the inverse of that a
/// computer can hold: from 1e-20 to 1e20.
Tunable read_weight(JsonObject& object, std::string_view key);

/// How every parameter given as "auto" is chosen, by whichever solver: the value with the least
/// mean relative error |image - truth| / |truth| of the conductivity change over the first 200
/// frames of the validation set that hold a contact (of a blank truth the error is not defined).
/// A frame whose image is undefined counts as error 1, that of the image without any contact;
/// one that has not converged counts with the image it has.
inline constexpr int choice_frames = 200;

/// Throws InputError where there is no validation set (`place` is where "auto" stands), where it
/// is of another sensor, or where no frame of it holds a contact.
ValidationFrames read_validation_frames(const FitInput& input, const std::string& place);

/// The mean relative error of `images` [frames, pixels] against the truths.
double mean_relative_error(const Images& images, std::span<const FrameReport> reports,
                           const Images& truths);
/// Computes, likewise, the error of the images that `solver` makes, on up to `threads` threads.
/// Frames are taken in blocks of a fixed size, so that the result does not depend on the number of
/// threads.
double mean_relative_error(const Solver& solver, const ValidationFrames& frames, int threads);

using ErrorOf = std::function<double(double value)>;

/// Chooses a number > 0: a ladder of `per_decade` values a decade from `low` to `high`, extended by
/// up to two decades while the best is at an end, then golden section in the logarithm around the
/// best until its place is known to within 5 %. Warns where the best stays at an end.
ParameterChoice choose_number(const std::string& place, double low, double high, int per_decade,
                              int frames, const ErrorOf& error_of);

/// `{"rule", "value", "error", "frames", "curve": [[value, error], ...]}`
nlohmann::json to_json(const ParameterChoice& choice);

/// Reads the "chosen" of parameters that a solver reported, so that they can be given back to it.
/// None where it is absent or was made for another value.
void read_chosen(JsonObject& parameters, Tunable& tunable);

}  // namespace ertbench
