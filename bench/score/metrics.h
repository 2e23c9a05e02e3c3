#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

namespace ertbench {

/// What is measured on one image. dσ is the true change of the conductivity, dσ^ the estimated one;
/// C1 ... C5 and D.1 are numbers in the supplement of the DD-ERT paper (Zheng et al.).
enum class Metric {
  AR,              ///< amplitude response sum(dσ^) / sum(dσ) (C1); ideal 1
  RES,             ///< (1 - sqrt((A50 - A_pixel) / A_total)) 100 (C2), %; ideal: that of the truth
  RES_error,       ///< |RES - RES of the truth|, %; ideal 0
  PE,              ///< distance of the centroid of dσ^ from the true centre (C3, C4), domain units
  PE25,            ///< PE after what is under 25 % of the largest |dσ^| is set to zero (D.1)
  RIE,             ///< ||σ^ - σ|| / ||σ||, absolute conductivities (C5); ideal 0
  relative_error,  ///< ||dσ^ - dσ|| / ||dσ||; ideal 0, the empty image scores 1
};

inline constexpr std::array kMetrics = {
    Metric::AR,   Metric::RES, Metric::RES_error,     Metric::PE,
    Metric::PE25, Metric::RIE, Metric::relative_error};

/// Those whose ideal is zero, the smaller the better.
inline constexpr std::array kErrorMetrics = {Metric::RES_error, Metric::PE, Metric::PE25,
                                             Metric::RIE, Metric::relative_error};

/// As in summary.json: "AR", "RES", "RES_error", "PE", "PE25", "RIE", "relative_error".
const char* name_of(Metric metric);
/// The inverse. Throws std::invalid_argument for another name.
Metric metric_from_name(const std::string& name);
/// With how many decimals the metric is shown.
int decimals_of(Metric metric);

/// One value for each metric.
template <typename Value>
struct PerMetric {
  std::array<Value, kMetrics.size()> values{};

  Value& operator[](Metric metric) { return values[static_cast<std::size_t>(metric)]; }
  const Value& operator[](Metric metric) const { return values[static_cast<std::size_t>(metric)]; }
};

/// The metrics of one frame; without a value where one is undefined. Default-constructed (all
/// undefined) it stands for a frame without a usable image.
using FrameMetrics = PerMetric<std::optional<double>>;

/// Compares one image with the truth.
/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// Undefined are
/// - all metrics, where a pixel of either image is not finite;
/// - RES, RES_error, PE and PE25 of an empty image: no |dσ^| above 1e-9 of the background;
/// - AR, RES_error, PE, PE25 and relative_error where the truth is empty in the same sense;
/// - PE and PE25 where the weights cancel, |sum| <= 1e-3 sum|.|: positive and negative parts are
///   then equal to a thousandth, and the centroid, amplified 1000 times, may lie anywhere. The same
///   holds for the sum of the true change in AR, and for its centroid where that is the true
///   centre.
///
/// The true centre is the contact's where the scene has exactly one and it lies wholly within the
/// sheet; otherwise the centroid of the true change. Throws std::invalid_argument where an image
/// has not the sensor's size.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene);

/// RES of one image of changes [pixels], %, whatever the truth (C2).
std::optional<double> resolution(const Sensor& sensor,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& change);

}  // namespace ertbench
