#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"

namespace ertbench {

/// The measure of an image that is taken as the strength of a touch.
enum class Strength { peak, sum };
inline constexpr std::array kStrengths = {Strength::peak, Strength::sum};
const char* name_of(Strength strength);

/// One press of one area that was held: what it was and what an image of it says.
struct PressStep {
  std::size_t press = 0;  ///< the sequence that it belongs to
  int area = 0;
  double force_N = 0;
  bool rising = true;             ///< the force was smaller before
  std::optional<double> peak;     ///< largest |δσ|, S/m
  std::optional<double> sum;      ///< |integral of δσ| over the sheet, S/m mm²
  std::optional<int> found_area;  ///< in which the touch was located

  std::optional<double> value(Strength strength) const {
    return strength == Strength::peak ? peak : sum;
  }
};

/// One solver on one set.
struct PressResponse {
  std::string label;
  std::string failure;  ///< why there is none; else empty
  struct Curve {
    std::vector<std::optional<Estimate>> rising;   ///< [forces] mean strength in the region
    std::vector<std::optional<Estimate>> falling;  ///< [forces] the same on the way back
    double spread = 0;  ///< standard deviation of the areas' means over their mean, largest force
    std::optional<Estimate> monotone;  ///< share of steps up in force that are steps up in strength
    std::optional<Estimate> hysteresis;  ///< mean of falling - rising over the rising curve's span
  };
  struct Reading {
    std::vector<Curve> regions;  ///< [regions]
    /// Mean |error| of the calibrated force, N.
    std::optional<Estimate> force_error;
    std::vector<std::optional<Estimate>> force_error_at;  ///< [forces]
    std::size_t unlocated = 0;                            ///< steps without a place or a strength
  };
  std::array<Reading, kStrengths.size()> readings;
};

struct SensitivitySet {
  std::string name;
  std::string condition;
  std::vector<double> forces_N;
  std::size_t presses = 0;
  std::vector<PressResponse> solvers;
};

/// D.2: how hard was it touched? The areas of the sheet are pressed with growing and falling force;
/// strengths are compared within the regions that the sheet's symmetries make of its areas.
Study sensitivity_study(const StudyInput& input);

/// Turns strength into force, region by region: means over the presses of each force, made monotone
/// (pool adjacent violators) and read backwards by straight lines; beyond the ends the end.
class ForceCalibration {
 public:
  ForceCalibration(const std::vector<PressStep>& steps, Strength strength,
                   const std::vector<int>& region_of);
  /// Nothing where the region had no strengths.
  std::optional<double> force_N(int region, double strength) const;

 private:
  struct Knot {
    double strength;
    double force;
  };
  std::vector<std::vector<Knot>> regions_;
};

/// `calibration` steps set the map from strength to force, `steps` are judged. `forces_N`
/// ascending.
PressResponse press_response(const std::vector<PressStep>& steps,
                             const std::vector<PressStep>& calibration,
                             const std::vector<double>& forces_N, const std::vector<int>& region_of,
                             const std::string& key);

}  // namespace ertbench
