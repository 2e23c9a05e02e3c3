#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "bench/contacts/contact_settings.h"
#include "bench/score/metric_table.h"
#include "forward/data/measured_frames.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

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

/// What was found in a frame, and how far contacts may be from the true ones.
struct FrameContacts {
  std::span<const FoundContact> found;
  ContactDistances distances;
};

/// Whether a metric can be told from what is known of a set: one of contacts needs their places,
/// any other the true images.
inline bool is_known(Metric metric, const Truth& truth) {
  return entry_of(metric).of_contacts ? truth.places : truth.images;
}

/// Compares one image, and the contacts that were found in it, with the truth.
/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// All metrics are undefined where a pixel of either image is not finite; where each of them is
/// undefined besides stands at its formula (metric_formulas.h). Throws std::invalid_argument where
/// an image has not the sensor's size.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene,
                           const FrameContacts& contacts);

/// The same with the contacts that the default rule reads out of the image, and the default
/// distances.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene);

/// That of one metric alone, where the others are not asked for.
std::optional<double> frame_metric(Metric metric, const Sensor& sensor,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const Scene& scene);

/// RES of one image of changes [pixels], %, whatever the truth (C2).
std::optional<double> resolution(const Sensor& sensor,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& change);

}  // namespace ertbench
