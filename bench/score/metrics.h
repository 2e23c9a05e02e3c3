#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "bench/score/metric_table.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"

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

/// Compares one image with the truth.
/// `conductivity` [pixels] S/m: the true image; `change` [pixels] S/m: the estimated dσ^.
///
/// All metrics are undefined where a pixel of either image is not finite; where each of them is
/// undefined besides stands at its formula (metric_formulas.h). Throws std::invalid_argument where
/// an image has not the sensor's size.
FrameMetrics frame_metrics(const Sensor& sensor,
                           const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                           const Eigen::Ref<const Eigen::RowVectorXd>& change, const Scene& scene);

/// The same of one metric alone, where the others are not asked for.
std::optional<double> frame_metric(Metric metric, const Sensor& sensor,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& conductivity,
                                   const Eigen::Ref<const Eigen::RowVectorXd>& change,
                                   const Scene& scene);

/// RES of one image of changes [pixels], %, whatever the truth (C2).
std::optional<double> resolution(const Sensor& sensor,
                                 const Eigen::Ref<const Eigen::RowVectorXd>& change);

}  // namespace ertbench
