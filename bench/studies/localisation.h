#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "bench/studies/error_statistics.h"
#include "bench/studies/study.h"

namespace ertbench {

/// A way to read the position of a touch out of an image.
enum class PlaceRule {
  raw,          ///< centroid of the whole image (C4)
  thresholded,  ///< after what is under 25 % of the largest value is set to zero (D.1)
  contact,      ///< the strongest contact that was detected
};
inline constexpr std::array kPlaceRules = {PlaceRule::raw, PlaceRule::thresholded,
                                           PlaceRule::contact};
const char* name_of(PlaceRule rule);

/// One solver's places on one set.
struct PlaceErrors {
  std::string label;
  std::string failure;  ///< why there are none; else empty
  struct Rule {
    std::optional<Estimate> mean, median, p95;  ///< mm
    std::optional<double> worst;                ///< mm
    std::optional<std::size_t> undefined = 0;   ///< frames without a place
  };
  std::array<Rule, kPlaceRules.size()> rules;
  /// [places] The thresholded rule's mean position, mm, where there is one, and the root mean
  /// square distance of the frames' positions from it.
  std::vector<std::optional<Eigen::Vector2d>> found;
  std::vector<double> scatter_mm;
};

/// Results of all solvers on one set.
struct LocalisedSet {
  std::string name;
  std::string condition;  ///< "disc of radius 10 mm, 5 N, 50 dB absolute"
  std::size_t frames = 0;
  std::vector<Eigen::Vector2d> places;  ///< mm
  /// [places] Cramér-Rao bound of the place's root mean square error, mm; empty without noise.
  std::vector<double> bound_mm;
  std::vector<PlaceErrors> solvers;
};

/// D.1: where was it touched? Touches at known places, each drawn many times; errors of the places
/// that are read out of the images, beside the least that any unbiased estimate can have.
Study localisation_study(const StudyInput& input);

/// The errors of places [frames] that were read by each rule; `place_of` [frames] numbers the true
/// places. `key` names the intervals' random numbers.
PlaceErrors place_errors(const std::vector<Eigen::Vector2d>& places,
                         const std::vector<std::size_t>& place_of,
                         const std::vector<FrameReading>& readings, const std::string& key);

}  // namespace ertbench
