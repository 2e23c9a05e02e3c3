#include "bench/score/score_probe.h"

#include <cmath>
#include <vector>

#include "bench/score/metrics.h"
#include "forward/sheet/rasterise.h"

namespace ertbench {
namespace {

constexpr int frames = 12;

/// Two discs that move from frame to frame.
Scene scene_of(int frame) {
  const double turn = 0.5 * frame;
  const auto disc = [](double x, double y, double radius, double ratio) {
    Contact contact;
    contact.centre = {x, y};
    contact.half_size = {radius, radius};
    contact.conductivity_ratio = ratio;
    return contact;
  };
  return {{disc(0.5 * std::cos(turn), 0.5 * std::sin(turn), 0.2 + 0.01 * frame, 0.4),
           disc(-0.45, 0.1 * std::cos(turn), 0.15, 0.7)}};
}

Eigen::RowVectorXd conductivity_of(const Scene& scene, const Sensor& sensor) {
  Eigen::VectorXd ratio(sensor.pixels());
  rasterise(scene, sensor.image(), Rasterisation::area, ratio);
  return sensor.background * ratio.transpose();
}

void add_summary(const MetricSummary& summary, std::vector<double>& out) {
  out.insert(out.end(), {summary.mean.value_or(0), summary.median.value_or(0),
                         static_cast<double>(summary.count)});
  if (summary.ci95) out.insert(out.end(), {summary.ci95->low, summary.ci95->high});
  if (summary.median_ci95) {
    out.insert(out.end(), {summary.median_ci95->low, summary.median_ci95->high});
  }
}

Probe computed() {
  const Sensor sensor;
  std::vector<FrameMetrics> scored;
  std::vector<double> contacts;
  Probe probe;
  for (int i = 0; i < frames; ++i) {
    const Scene scene = scene_of(i);
    const Eigen::RowVectorXd truth = conductivity_of(scene, sensor);
    // A weaker image one frame late, with an artefact.
    Eigen::RowVectorXd change =
        0.8 * (conductivity_of(scene_of(i - 1), sensor).array() - sensor.background);
    for (Eigen::Index p = 0; p < change.size(); ++p) {
      change[p] += 0.002 * std::sin(0.3 * static_cast<double>(p) + i);
    }
    scored.push_back(frame_metrics(sensor, truth, change, scene));
    for (const FoundContact& one : contacts_of_image(sensor, ContactRule{}, change)) {
      contacts.insert(contacts.end(), {one.place.x(), one.place.y(), 100 * one.strength});
    }
  }
  const PerMetric<MetricSummary> summaries = summarise(scored);
  for (const Metric metric : kMetrics) {  // a part each, as their sizes differ
    std::vector<double> values;
    for (const FrameMetrics& one : scored) values.push_back(one[metric].value_or(0));
    add_summary(summaries[metric], values);
    probe.add(Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values)));
  }
  probe.add(Eigen::Map<const Eigen::VectorXd>(contacts.data(), std::ssize(contacts)));
  return probe;
}

}  // namespace

Probe score_probe() { return cached_probe("scores", computed); }

}  // namespace ertbench
